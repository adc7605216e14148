"""The task generator: a whole set made and timed, every task of it checked, and ten of each level solved.

--tasks DIR checks and solves a set that is there already; --quick makes twenty tasks and solves none.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path

from benchmarks.parts.harness import Row, main
from benchmarks.parts.jobs import solve_all
from tamp.cli import main as tamp
from tamp.execution.settling.settle import settle
from tamp.generate.levels import LEVELS
from tamp.generate.placement.object_model import Thing, thing
from tamp.generate.reach import reachable
from tamp.generate.run import OBJECTS
from tamp.scenarios.library.model import read_library
from tamp.task import At, Object, Pose, Task
from tamp.task.files.load import load_task

SOLVED_EACH = 10
ASKED = "1,400 tasks in under 3600 s on 2 cores; each loads, drifts under 5 mm, in reach; the share solved is told"


@dataclass(frozen=True)
class Check:
    """What became of one file.

    Attributes:
        file: the task's.
        level: of the task.
        drift: how far anything moves when its start or its goal scene is settled [m].
        in_reach: whether the robot reaches every object at its start and at its goal.
    """

    file: Path
    level: int | None
    drift: float
    in_reach: bool


def rows(quick: bool, tasks: Path | None) -> Iterator[Row]:
    """One row for making them all, one for each level."""
    with tempfile.TemporaryDirectory() as name:
        folder = tasks or Path(name)
        if tasks is None:
            yield _make(folder, 20 if quick else 1400)
        with ProcessPoolExecutor(2, get_context("spawn")) as pool:
            checks = list(pool.map(check, sorted(folder.glob("*.yaml")), chunksize=5))
        for level in LEVELS:
            yield _level(
                level.number, [one for one in checks if one.level == level.number], 0 if quick else SOLVED_EACH
            )


def _make(folder: Path, number: int) -> Row:
    begin = time.monotonic()
    if tamp(["generate", "-n", str(number), "--seed", "0", "--workers", "2", "-o", str(folder)]) != 0:
        sys.exit("tamp generate failed")
    return {"level": "all", "tasks": number, "made_in_s": time.monotonic() - begin}


def check(file: Path) -> Check:
    """Load a task, settle both of its scenes and ask whether the robot reaches them."""
    task = load_task(file)
    scenes = [{o.name: o.pose for o in task.objects}, {o.name: _goal(o) for o in task.objects}]
    drift = max(max(settle(task, poses).moved.values()) for poses in scenes)
    return Check(file, task.level, drift, _in_reach(task, scenes))


def _in_reach(task: Task, scenes: Sequence[dict[str, Pose]]) -> bool:
    assert task.path is not None
    things = _things(task.path.parent / OBJECTS)
    return all(reachable(things[o.shape], poses[o.name].matrix) for poses in scenes for o in task.objects)


@cache
def _things(library: Path) -> dict[object, Thing]:
    return {model.shape: thing(model) for model in read_library(library)}


def _goal(item: Object) -> Pose:
    assert isinstance(item.goal, At)
    return item.goal.pose


def _level(level: int, checks: Sequence[Check], solving: int) -> Row:
    row: Row = {"level": level, "tasks": len(checks)}
    if checks:
        row["drift_max_mm"] = 1000 * max(one.drift for one in checks)
        row["in_reach"] = f"{sum(one.in_reach for one in checks)} of {len(checks)}"
    if solving and checks:
        results = list(solve_all([one.file for one in checks[:solving]], seeds=[0]))
        idle = [result.do_nothing_ede_m or 0.0 for result in results]
        # What was not carried out left the table as it was.
        errors = [one if result.ede_m is None else result.ede_m for result, one in zip(results, idle, strict=True)]
        row["solved"] = f"{sum(result.status == 'solved' for result in results)} of {len(results)}"
        row |= {"ede_cm": 100 * sum(errors) / len(errors), "idle_cm": 100 * sum(idle) / len(idle)}
    return row


if __name__ == "__main__":
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--tasks", type=Path, metavar="DIR", help="a set that `tamp generate` made")
    main("generate", lambda quick, tasks: list(rows(quick, tasks)), extra=parser, asked=ASKED)
