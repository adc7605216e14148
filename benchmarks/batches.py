"""A large batch of one-box tasks, planned and not executed: what a run costs beside its planning, and who keeps memory.

`overhead` is what passes between a worker's start and its end while it neither prepares nor plans: forking, imports,
compiled loops, the robot's tables, the files of the run. `beside` is the processor time of the batch's own process and
of the server that workers are forked from. Their memory is what the operating system says is resident.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.parts.harness import Row, main, percentile
from tamp.batch import Batch
from tamp.batch.pool import Job, Outcome, run_jobs
from tamp.batch.processes import PROC, tree
from tamp.scenarios.families import FAMILIES
from tamp.task import Task
from tamp.task.files.load import load_task
from tamp.task.files.save import save_task

ASKED = "overhead_s under 0.5, 1,000 tasks under 300 s on two cores, memory at the end as after a tenth"


def run(quick: bool, tasks: int, workers: int, robot: str | None) -> Sequence[Row]:
    with tempfile.TemporaryDirectory() as folder:
        return [_batch(_one_box(20 if quick else tasks, Path(folder)), workers, robot, Path(folder) / "out")]


def _one_box(count: int, folder: Path) -> list[Task]:
    """So many tasks with one box, no two alike, read from their files as those of a user are."""
    files = []
    for index in range(count):
        task = FAMILIES[("sort", "clutter")[index % 2]](1, index // 2)
        files.append(folder / f"{task.name}.yaml")
        save_task(task, files[-1])
    return [load_task(file) for file in files]


def _batch(tasks: Sequence[Task], workers: int, robot: str | None, output: Path) -> Row:
    watched = _Watched()
    began = time.monotonic()
    options = {"execute": False, "robot": robot}
    batch = Batch(tasks, options=options, workers=workers, output=output, executor=watched.run)
    planned = sum(result.status == "planned" for result in batch.run())
    return {
        "tasks": len(tasks),
        "planned": planned,
        "wall_s": time.monotonic() - began,
        "processor_s": _processor_s(),
        "beside_s": _processor_s(own=True),
        "overhead_s": median(watched.overheads),
        "overhead_95_s": percentile(watched.overheads, 95),
        "planning_s": median(watched.planning),
        "memory_tenth_mib": watched.memory[len(watched.memory) // 10] / 2**20,
        "memory_end_mib": watched.memory[-1] / 2**20,
    }


@dataclass
class _Watched:
    """Runs jobs as a batch does, and looks at each outcome as it comes; keeps numbers only."""

    overheads: list[float] = field(default_factory=list)
    planning: list[float] = field(default_factory=list)
    memory: list[int] = field(default_factory=list)

    def run(self, jobs: Iterable[Job], work: str, **bounds: Any) -> Iterator[Outcome]:
        for outcome in run_jobs(jobs, work, **bounds):
            if outcome.value is not None:
                self.overheads.append(outcome.wall_s - outcome.value["wall_s"])
                self.planning.append(outcome.value["planning_s"])
            self.memory.append(sum(_lasting().values()))
            yield outcome


def _lasting() -> dict[int, int]:
    """This process, and those below it that are no workers, with their memory: a worker leads a session of its own."""
    own = os.getpid(), os.getsid(0)
    return {pid: memory for pid, memory in tree(own[0]).items() if pid == own[0] or _session(pid) == own[1]}


def _session(pid: int) -> int | None:
    try:
        return os.getsid(pid)
    except ProcessLookupError:
        return None


def _processor_s(own: bool = False) -> float:
    """Processor time of this process and of all below it, workers that have ended included [s]."""
    ticks = 0
    for pid in _lasting():
        fields = (PROC / str(pid) / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        ticks += sum(map(int, fields[11:13] if own else fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--tasks", type=int, default=1000, metavar="N")
    parser.add_argument("--workers", type=int, default=2, metavar="N")
    parser.add_argument("--robot", metavar="NAME", help="in place of the tasks' own")
    main("batches", run, extra=parser, asked=ASKED)
