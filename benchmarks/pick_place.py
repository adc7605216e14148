"""One whole pick and place in clutter: grasp, inverse kinematics, four motions beside approach and lift, and timing."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from benchmarks.parts.harness import Row, main, percentile
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.planning import solve
from tamp.scenarios.families import sort
from tamp.task import At, Pose, Task, load_robot

CLUTTER = 10
RUNS = 60


def rows(quick: bool) -> Iterator[Row]:
    """Times of single pick-and-place problems: one box of ten goes to a free place, the other nine stay."""
    times = [seconds for run in range(5 if quick else RUNS + 1) if (seconds := _one(run)) is not None][1:]
    yield {
        "runs": len(times),
        "clutter": CLUTTER,
        "median_ms": 1e3 * percentile(times, 50),
        "p95_ms": 1e3 * percentile(times, 95),
        "max_ms": 1e3 * max(times),
    }


def _one(seed: int) -> float | None:
    """Seconds from grasp to timed motions, None where the drawn goal is out of reach."""
    rng = np.random.default_rng(seed)
    crowd = sort(CLUTTER, seed)
    first, *others = crowd.objects
    goal = Pose.from_rpy(
        (float(rng.uniform(-0.05, 0.12)), float(rng.uniform(-0.4, -0.2)), first.pose.xyz[2]),
        (0.0, 0.0, float(rng.uniform(-1.0, 1.0))),
    )
    moved = type(first)(first.name, first.shape, first.pose, At(goal))
    kept = [type(o)(o.name, o.shape, o.pose) for o in others]
    setup = prepare(Task(f"pick_place_{seed}", (moved, *kept)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    begin = time.perf_counter()
    problem = attempt.problem(attempt.workspace, {})
    solution = solve(problem, timeout=10.0, seed=seed)
    if solution.plan is None:
        return None
    setup.domain.timed(attempt.workspace, solution.plan)
    return time.perf_counter() - begin


if __name__ == "__main__":
    main(
        "pick_place",
        lambda quick: list(rows(quick)),
        asked="median_ms at most 150",
    )
