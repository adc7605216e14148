"""Time parametrisation: random paths of the Panda under the maker's limits, judged on the sampled trajectories.

Paths are chains of random edges, from 1 mrad to several rad long. `velocity` and `acceleration` are the largest shares
by which any sampled trajectory exceeds a limit (negative: never reached), accelerations by differences of velocities.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.parts.harness import Row, main, percentile
from tamp.checking.robot.trajectory_limits import violations
from tamp.checking.tolerances import Tolerances
from tamp.task import RobotSpec, load_robot
from tamp.world.timing.time_parametrization import time_path
from tamp.world.timing.trajectory import accelerations, largest_deviation, largest_jerk

Array = NDArray[np.float64]


def run(quick: bool) -> Iterator[Row]:
    spec = load_robot("panda")
    rng = np.random.default_rng(0)
    paths = [random_path(spec, rng) for _ in range(100 if quick else 1000)]
    time_path(paths[0], spec)
    for speed in (1.0, 0.2):
        yield _row(paths, spec, speed)


def _row(paths: list[Array], spec: RobotSpec, speed: float) -> Row:
    seconds, trajectories = [], []
    for path in paths:
        start = time.perf_counter()
        trajectories.append(time_path(path, spec, speed=speed))
        seconds.append(time.perf_counter() - start)
    velocity, acceleration = speed * np.array(spec.velocity), speed * np.array(spec.acceleration)
    tolerances = Tolerances()
    return {
        "speed": speed,
        "paths": len(paths),
        "median_ms": 1e3 * percentile(seconds, 50),
        "p95_ms": 1e3 * percentile(seconds, 95),
        "velocity": max(float((np.abs(t.velocities) / velocity).max()) for t in trajectories) - 1,
        "acceleration": max(float((np.abs(accelerations(t)) / acceleration).max()) for t in trajectories) - 1,
        "deviation_rad": max(largest_deviation(t, p) for t, p in zip(trajectories, paths, strict=True)),
        "refused_by_checker": sum(any(True for _ in violations(t, spec, tolerances)) for t in trajectories),
        "jerk_over_limit": percentile([float((largest_jerk(t) / spec.jerk).max()) for t in trajectories], 50),
        "mean_duration_s": float(np.mean([t.duration for t in trajectories])),
    }


def random_path(spec: RobotSpec, rng: np.random.Generator) -> Array:
    """A chain of 1 to 10 random edges within the limits, some of them tiny, shape (n, dof)."""
    lower, upper = np.array(spec.lower), np.array(spec.upper)
    waypoints = [rng.uniform(lower, upper)]
    for _ in range(int(rng.integers(1, 11))):
        edge = rng.normal(size=len(lower)) * rng.choice([0.001, 0.01, 0.1, 0.5])
        waypoints.append(np.clip(waypoints[-1] + edge, lower, upper))
    return np.array(waypoints)


if __name__ == "__main__":
    main(
        "timing",
        lambda quick: list(run(quick)),
        asked="velocity and acceleration at most 0.001, deviation_rad under 0.005, median_ms under 10",
    )
