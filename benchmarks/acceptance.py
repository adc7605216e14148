"""Plans of ours before the checker: are all accepted at once, and does the slow oracle find nothing in them?

Planning hands out only what the checker accepts; here also those count that it sent back (`rejected`), and those that
never reached it because their timed motions came too near to something (`not_free`). Each is printed with its reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import tamp
from benchmarks.parts.harness import Row, main
from benchmarks.parts.small_tasks import small_tasks
from tamp.errors import PlanningFailure
from tamp.task import Task
from tests.checking.oracle import wrong

COUNTS = ("tasks", "planned", "rejected", "not_free", "no_plan", "oracle_wrong")


def run(quick: bool) -> Sequence[Row]:
    tasks = sorted(small_tasks(20 if quick else 1000), key=_family)
    rows = [_row(family, list(group)) for family, group in groupby(tasks, key=_family)]
    return [*rows, {"family": "all", **{key: sum(row[key] for row in rows) for key in COUNTS}}]


def _family(task: Task) -> str:
    """The task's name without its size and seed."""
    return task.name.rstrip("0123456789_")


def _row(family: str, tasks: Sequence[Task]) -> Row:
    row: Row = {"family": family, **dict.fromkeys(COUNTS, 0), "tasks": len(tasks)}
    for task in tasks:
        for key in _count(task):
            row[key] += 1
    return row


def _count(task: Task) -> list[str]:
    """What is to be counted of one task."""
    try:
        plan = tamp.plan(task, seed=0)
    except PlanningFailure as failure:
        print(f"{task.name}: {failure}")
        return ["no_plan"]
    counts = ["planned"]
    for count, key in (("rejected", "rejected"), ("not_free", "blocked")):
        for reason in plan.report[key]:
            print(f"{task.name}: {count}: {reason}")
            counts.append(count)
    if (seen := wrong(task, plan)) is not None:
        print(f"{task.name}: the oracle says: {seen}")
        counts.append("oracle_wrong")
    return counts


if __name__ == "__main__":
    main("acceptance", run)
