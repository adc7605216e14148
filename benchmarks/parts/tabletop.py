"""One planning run in the tabletop world, timed in its two parts: the stream planner, and everything round it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from tamp.domains.timing import NotFree
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.planning import solve
from tamp.task import Task, load_robot


@dataclass(frozen=True)
class PlanningRun:
    """What one run cost.

    Attributes:
        solved: whether the stream planner found a plan that the checker accepts.
        solve_s: the stream planner with all its samplers, motions included [wall s].
        around_s: settling, timing and checking [wall s].
        moved: how often an object was picked up.
        why: the planner's status, or the checker's verdict.
    """

    solved: bool
    solve_s: float
    around_s: float
    moved: int
    why: str


def run(task: Task, seed: int, timeout: float) -> PlanningRun:
    """Plan a task once, check the plan, and say what it cost."""
    begin = time.perf_counter()
    setup = prepare(task)
    attempt = Attempt.of(setup, setup.start, load_robot(task.robot).home, None)
    problem = attempt.problem(attempt.workspace, {})
    ready = time.perf_counter()
    solution = solve(problem, timeout=timeout, seed=seed)
    found = time.perf_counter()
    if solution.plan is None:
        return PlanningRun(False, found - ready, ready - begin, 0, solution.status)
    moved = sum(action.name in ("pick", "unstack") for action in solution.plan)
    try:
        verdict = attempt.checked(attempt.timed(solution.plan, seed, {}))
    except NotFree as reason:
        return PlanningRun(False, found - ready, ready - begin, moved, str(reason))
    around = ready - begin + time.perf_counter() - found
    return PlanningRun(verdict.accepted, found - ready, around, moved, str(verdict))


def warm_up(task: Task) -> None:
    """Load every library and cache once, so that the first run measured is like the others."""
    run(task, seed=0, timeout=60.0)


def median(values: Sequence[float]) -> float:
    """The middle value, the lower of two."""
    return sorted(values)[(len(values) - 1) // 2]
