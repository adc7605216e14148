"""Tables of boxes through `tamp.plan`, from the settled start to the checked plan.

`--family` and `--boxes` choose one row: `python -m benchmarks.tables --family towers --boxes 40 --seeds 5`.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass

import tamp
from benchmarks.parts.harness import Row, main
from benchmarks.parts.tabletop import median
from tamp.errors import PlanningFailure
from tamp.scenarios.families import FAMILIES, sort
from tamp.task import Task

TABLES = (("sort", 10), ("stack", 10), ("clutter", 9), ("permutation", 10))
DENSE = tuple((family, n) for family in ("dense", "towers") for n in (5, 10, 20, 40))
QUICK = (("sort", 10), ("clutter", 9), ("dense", 10))
SEEDS = 5
LIMIT_S = 60.0  # in processor time


@dataclass(frozen=True)
class PlannedTable:
    """What one call of `tamp.plan` cost.

    Attributes:
        processor_s, wall_s: time for everything [s].
        actions: of the plan; None where there is none.
        why: the failure's first line.
    """

    processor_s: float
    wall_s: float
    actions: int | None
    why: str = ""


def planned(task: Task, seed: int) -> PlannedTable:
    """Plan a task once."""
    processor, wall = time.process_time(), time.perf_counter()
    actions, why = None, ""
    try:
        actions = len(tamp.plan(task, seed=seed, timeout=LIMIT_S, clock="processor").actions)
    except PlanningFailure as failure:
        why = str(failure).partition("\n")[0]
    return PlannedTable(time.process_time() - processor, time.perf_counter() - wall, actions, why)


def rows(quick: bool, family: str | None, boxes: int | None, seeds: int) -> Iterator[Row]:
    """One row for each family and number of boxes."""
    planned(sort(1, 0), 0)  # loads every library
    chosen = QUICK if quick else (*TABLES, *DENSE)
    cases = [case for case in chosen if family in (None, case[0]) and boxes in (None, case[1])]
    if not cases and family is not None and boxes is not None:
        cases = [(family, boxes)]
    for name, n in cases:
        yield _row(name, n, 1 if quick else seeds)


def _row(family: str, n: int, seeds: int) -> Row:
    runs = [planned(FAMILIES[family](n, seed), seed) for seed in range(seeds)]
    processor = [run.processor_s for run in runs]
    return {
        "family": family,
        "n": n,
        "solved": f"{sum(run.actions is not None for run in runs)} of {len(runs)}",
        "processor_s": median(processor),
        "wall_s": median([run.wall_s for run in runs]),
        "max_processor_s": max(processor),
        "a_box_s": median(processor) / n,
        "actions": median([run.actions or 0 for run in runs]),
        "unsolved": "; ".join(sorted({run.why for run in runs if run.why}))[:80],
    }


def options() -> argparse.ArgumentParser:
    """What this benchmark takes beside what all do."""
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--family", choices=sorted(FAMILIES), help="of this family only")
    parser.add_argument("--boxes", type=int, metavar="N", help="with so many boxes only")
    parser.add_argument("--seeds", type=int, default=SEEDS, metavar="N", help=f"tasks in a row of the table ({SEEDS})")
    return parser


if __name__ == "__main__":
    main(
        "tables",
        lambda quick, family, boxes, seeds: list(rows(quick, family, boxes, seeds)),
        extra=options(),
        asked="processor_s of sort and stack at most 1.0, of clutter 0.6; dense and towers of 40 all solved in 20 s, "
        "a_box_s at 40 at most twice that at 5",
    )
