"""Rearrangement with occupied goals: the goals of n boxes are a random permutation of their starts.

A permutation needs one move for each box that is not at its goal, and one more (a buffer) for each cycle.
"""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.parts.harness import Row, main
from benchmarks.parts.tabletop import median, run, warm_up
from benchmarks.planner import summary
from tamp.scenarios.families import permutation
from tamp.task import At, Task

SIZES = (4, 8, 12, 16)
SEEDS = range(6)
LIMIT_S = 60.0


def rows(quick: bool) -> Iterator[Row]:
    """One row for each size."""
    warm_up(permutation(2, 0))
    for n in SIZES[:2] if quick else SIZES:
        tasks = [permutation(n, seed) for seed in (range(1) if quick else SEEDS)]
        runs = [run(task, seed, LIMIT_S) for seed, task in enumerate(tasks)]
        extra = [r.moved - least_moves(task) for r, task in zip(runs, tasks, strict=True) if r.solved]
        yield {**summary("permutation", n, runs), "extra_moves": median(extra) if extra else "-"}


def least_moves(task: Task) -> int:
    """One move for each displaced box and one more for each cycle of displaced boxes."""
    at = {obj.pose.xyz[:2]: obj.name for obj in task.objects}
    wants = {obj.name: at[obj.goal.pose.xyz[:2]] for obj in task.objects if isinstance(obj.goal, At)}
    displaced = {name for name, holder in wants.items() if name != holder}
    cycles, waiting = 0, set(displaced)
    while waiting:
        cycles += 1
        name = min(waiting)
        while name in waiting:
            waiting.remove(name)
            name = wants[name]
    return len(displaced) + cycles


if __name__ == "__main__":
    main("rearrangement", lambda quick: list(rows(quick)))
