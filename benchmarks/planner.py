"""The stream planner in our world with the Panda: sort, stack, clutter, and how its time grows.

PDDLStream's adaptive algorithm on a machine of this kind, median seconds of the runs it solves at n = 10 (Kuka; the
time is that of its planner): sort 8.9 (3 of 6 solved), stack 17.9 (4 of 6), clutter at n = 9: 7.9.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from benchmarks.parts.harness import Row, main
from benchmarks.parts.tabletop import PlanningRun, median, run, warm_up
from tamp.scenarios.families import clutter, sort, stack
from tamp.task import Task

SIZES = {"sort": (1, 2, 4, 6, 8, 10), "stack": (1, 2, 4, 6, 8, 10), "clutter": (1, 2, 4, 6, 8, 9)}
FAMILIES: dict[str, Callable[[int, int], Task]] = {"sort": sort, "stack": stack, "clutter": clutter}
SEEDS = range(12)
GROWTH = (5, 20, 40)
GROWTH_SEEDS = range(3)
LIMIT_S = 60.0


def rows(quick: bool) -> Iterator[Row]:
    """One row for each family and size."""
    warm_up(sort(1, 0))
    for family, sizes in SIZES.items():
        for n in (2, 6) if quick else sizes:
            yield _row(family, n, [0] if quick else SEEDS)
    for family in () if quick else ("sort", "stack"):
        for n in GROWTH:
            yield _row(f"{family}, growth", n, GROWTH_SEEDS)


def _row(name: str, n: int, seeds: Sequence[int]) -> Row:
    family = FAMILIES[name.partition(",")[0]]
    runs = [run(family(n, seed), seed, LIMIT_S) for seed in seeds]
    return summary(name, n, runs)


def summary(name: str, n: int, runs: Sequence[PlanningRun]) -> Row:
    """Solved runs, and times of all runs."""
    times = [r.solve_s for r in runs]
    return {
        "family": name,
        "n": n,
        "solved": f"{sum(r.solved for r in runs)} of {len(runs)}",
        "median_s": median(times),
        "max_s": max(times),
        "a_box_s": median(times) / n,
        "around_s": median([r.around_s for r in runs]),
        "moves": median([r.moved for r in runs]),
        "unsolved": "; ".join(sorted({r.why for r in runs if not r.solved}))[:80],
    }


if __name__ == "__main__":
    main("planner", lambda quick: list(rows(quick)))
