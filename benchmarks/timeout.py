"""A timeout of T seconds ends planning within T + 1 s, on tasks that planning would have gone on with.

Settling, reading of meshes and checking count too. `over_s` is how long after its timeout a run ended; `late` counts
those of over a second and must be 0. `work_s` is the processor's time spent after the timeout, which says the same of a
machine that is busy with other things. Runs that ended long before their timeout prove nothing and are not counted.
A last row has samplers of grasps that sleep or spin for ever.
"""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import tamp
from benchmarks.harness import Row, main, percentile
from tamp.errors import PlanningFailure
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.scenarios.families import FAMILIES
from tamp.task import Task
from tamp.task.files.load import load_task

HARD = (("permutation", 20), ("sort", 40), ("stack", 40), ("clutter", 9), ("permutation", 16), ("stack", 30))
OCRTOC = Path("../shared/ocrtoc/2021")
GRACE_S = 1.0


def run(quick: bool) -> Sequence[Row]:
    wanted = 2 if quick else 20
    tamp.plan(FAMILIES["sort"](1, 0), seed=0)  # loads the libraries, which is no part of planning
    with tempfile.TemporaryDirectory() as folder:
        tasks = cycle(hard_tasks(Path(folder)))
        rows = [_row(timeout, tasks, wanted) for timeout in (1.0, 2.0, 3.0, 4.0, 5.0)]
    task = FAMILIES["sort"](1, 0)
    hanging = [
        planned(task, timeout, {"sample-grasp": sampler}) for sampler in (sleeps, spins) for timeout in (2.0, 5.0)
    ]
    return [*rows, _summary("hanging", [over for over, _ in hanging], [work for _, work in hanging])]


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
        tamp.plan(task, seed=0, timeout=timeout, samplers=samplers)
    except PlanningFailure:
        pass
    finally:
        timer.cancel()
    over, now = time.monotonic() - start - timeout, time.process_time()
    return over, now - at_timeout[0] if at_timeout else 0.0


if __name__ == "__main__":
    main("timeout", run)
