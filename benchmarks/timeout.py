"""A timeout of T seconds ends planning within T + 1 s, on tasks that planning would have gone on with.

Settling, reading of meshes and checking count too. `over_s` is how long after its timeout a run ended; `late` counts
those of over a second and must be 0. `work_s` is the processor's time spent after the timeout, which says the same of a
machine that is busy with other things. Runs that ended long before their timeout prove nothing and are not counted.
A last row has samplers of grasps that sleep or spin for ever.

With --limits 5 20 60 it asks instead for OCRTOC's tasks, each with such a sampler, under each of these limits;
--tasks N takes so many of the fifty, and --loaded keeps all cores busy meanwhile.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from itertools import cycle
from pathlib import Path
from typing import Any

import tamp
from benchmarks.parts.harness import Row, main, percentile
from tamp.errors import PlanningFailure
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.scenarios.families import FAMILIES
from tamp.task import Task
from tamp.task.files.load import load_task

HARD = (("permutation", 20), ("sort", 40), ("stack", 40), ("clutter", 9), ("permutation", 16), ("stack", 30))
OCRTOC = Path("../shared/ocrtoc/2021")
GRACE_S = 1.0


def run(quick: bool, limits: Sequence[float] | None, tasks: int, loaded: bool) -> Sequence[Row]:
    if limits:
        return hanging_rows(limits, 2 if quick else tasks, loaded)
    wanted = 2 if quick else 20
    tamp.plan(FAMILIES["sort"](1, 0), seed=0)  # loads the libraries, which is no part of planning
    with tempfile.TemporaryDirectory() as folder:
        hard = cycle(hard_tasks(Path(folder)))
        rows = [_row(timeout, hard, wanted) for timeout in (1.0, 2.0, 3.0, 4.0, 5.0)]
    task = FAMILIES["sort"](1, 0)
    hanging = [
        planned(task, timeout, {"sample-grasp": sampler}) for sampler in (sleeps, spins) for timeout in (2.0, 5.0)
    ]
    return [*rows, _summary("hanging", [over for over, _ in hanging], [work for _, work in hanging])]


def hanging_rows(limits: Sequence[float], tasks: int, loaded: bool) -> list[Row]:
    """For each limit, so many of OCRTOC's tasks with a sampler of grasps that hangs: sleeping and spinning in turn."""
    if not OCRTOC.is_dir():
        sys.exit(f"OCRTOC's tasks are not in {OCRTOC}")
    tamp.plan(FAMILIES["sort"](1, 0), seed=0)  # loads the libraries, which is no part of planning
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        files = import_ocrtoc(OCRTOC, Path(folder)).paths
        chosen = [load_task(file) for file in files[:: max(1, len(files) // tasks)][:tasks]]
        for _ in range(os.cpu_count() or 1) if loaded else ():
            busy = stack.enter_context(subprocess.Popen([sys.executable, "-c", "while True: pass"]))
            stack.callback(busy.kill)
        return [_hanging_row(limit, chosen) for limit in limits]


def _hanging_row(limit: float, tasks: Sequence[Task]) -> Row:
    samplers = cycle((sleeps, spins))
    found = [planned(task, limit, {"sample-grasp": next(samplers)}) for task in tasks]
    for task, (over, _) in zip(tasks, found, strict=True):
        if over > GRACE_S:
            print(f"{task.name}: {limit:g} s took {limit + over:.2f} s", flush=True)
    return _summary(f"{limit:g} hanging", [over for over, _ in found], [work for _, work in found])


def sleeps(context: Any, obj: str) -> Iterator[Any]:
    """Sleep for longer than anybody waits."""
    time.sleep(3600.0)
    yield


def spins(context: Any, obj: str) -> Iterator[Any]:
    """Never yield."""
    while True:
        pass


def hard_tasks(folder: Path) -> list[Task]:
    """Large members of the families and, where its files are at hand, OCRTOC's tasks with many objects."""
    tasks = [FAMILIES[family](n, seed) for seed in (0, 1) for family, n in HARD]
    if OCRTOC.is_dir():
        imported = [load_task(file) for file in import_ocrtoc(OCRTOC, folder).paths]
        tasks += [task for task in imported if sum(o.goal is not None for o in task.objects) >= 5]
    return tasks


def _row(timeout: float, tasks: Iterator[Task], wanted: int) -> Row:
    overs: list[float] = []
    works: list[float] = []
    while len(overs) < wanted:
        task = next(tasks)
        over, work = planned(task, timeout)
        if over < -0.2 * timeout:  # the search gets a little less than the whole time
            continue
        overs.append(over)
        works.append(work)
        if over > GRACE_S:
            print(f"{task.name}: {timeout:g} s took {timeout + over:.2f} s", flush=True)
    return _summary(f"{timeout:g}", overs, works)


def _summary(title: str, overs: Sequence[float], works: Sequence[float]) -> Row:
    return {
        "timeout_s": title,
        "runs": len(overs),
        "late": sum(over > GRACE_S for over in overs),
        "over_s": percentile(overs, 50),
        "over_max_s": max(overs),
        "work_s": percentile(works, 50),
        "work_max_s": max(works),
    }


def planned(task: Task, timeout: float, samplers: Mapping[str, Any] | None = None) -> tuple[float, float]:
    """How long after its timeout planning ended [wall s], and the processor's time it took after it [s]."""
    start, at_timeout = time.monotonic(), list[float]()
    timer = threading.Timer(timeout, lambda: at_timeout.append(time.process_time()))
    timer.start()
    try:
        tamp.plan(task, seed=0, timeout=timeout, samplers=samplers or {})
    except PlanningFailure:
        pass
    finally:
        timer.cancel()
    over, now = time.monotonic() - start - timeout, time.process_time()
    return over, now - at_timeout[0] if at_timeout else 0.0


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--limits", type=float, nargs="+", metavar="S", help="OCRTOC's tasks with samplers that hang")
    parser.add_argument("--tasks", type=int, default=50, metavar="N", help="how many of them; default 50")
    parser.add_argument("--loaded", action="store_true", help="keep all cores busy meanwhile")
    return parser


if __name__ == "__main__":
    main("timeout", run, extra=_options(), asked="late 0")
