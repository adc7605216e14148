"""Questions to a trajectory: where it is, its accelerations and jerk, how far it strays, what is in its way."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tamp.compiled import compiled
from tamp.task.plan import Trajectory
from tamp.world.motion.paths import Array, deviation


class ConfigurationTest(Protocol):
    """Says whether a configuration is free; `tamp.world.collision.checker.CollisionChecker` is one."""

    def travel(self, configurations: Array, /) -> Array:
        """Metres that no moving point moves beyond between each two configurations, (n, dof): shape (n - 1,)."""

    def free(self, q: Array, /) -> bool:
        """Whether the configuration, shape (dof,), is free of collision."""


def first_blocked(trajectory: Trajectory, checker: ConfigurationTest, step: float) -> float | None:
    """Time of the first configuration in collision [s], tested every `step` [m] of motion of the fastest point."""
    distance = np.concatenate([[0.0], np.cumsum(checker.travel(trajectory.positions))])
    # A tenth to spare, as the motion within a sample is not quite uniform.
    marks = np.linspace(0.0, distance[-1], max(2, int(np.ceil(distance[-1] / (0.9 * step))) + 1))
    times = np.interp(marks, distance, trajectory.times)
    for time, q in zip(times, positions_at(trajectory, times), strict=True):
        if not checker.free(q):
            return float(time)
    return None


def positions_at(trajectory: Trajectory, times: Array) -> Array:
    """Positions of the cubic Hermite curve at `times` [s], shape (k,): shape (k, dof) [rad]."""
    return _hermite(trajectory.times, trajectory.positions, trajectory.velocities, np.asarray(times, dtype=float))


@compiled
def _hermite(t: Array, q: Array, v: Array, times: Array) -> Array:
    found = np.empty((len(times), q.shape[1]))
    for k in range(len(times)):
        i = min(max(np.searchsorted(t, times[k], side="right") - 1, 0), len(t) - 2)
        h = t[i + 1] - t[i]
        s = (times[k] - t[i]) / h
        for j in range(q.shape[1]):
            way, v0, v1 = q[i + 1, j] - q[i, j], h * v[i, j], h * v[i + 1, j]
            found[k, j] = q[i, j] + s * (v0 + s * (3 * way - 2 * v0 - v1 + s * (v0 + v1 - 2 * way)))
    return found


def peak_velocities(trajectory: Trajectory) -> Array:
    """The largest absolute velocity of the cubic Hermite curve from each sample to the next, (n - 1, dof) [rad/s]."""
    start, end = trajectory.velocities[:-1], trajectory.velocities[1:]
    mean = np.diff(trajectory.positions, axis=0) / np.diff(trajectory.times)[:, None]
    bend, slope = 3.0 * (start + end) - 6.0 * mean, 6.0 * mean - 4.0 * start - 2.0 * end
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.nan_to_num(np.clip(-slope / (2.0 * bend), 0.0, 1.0))
    between = start + share * (slope + share * bend)
    return np.asarray(np.abs([start, between, end]).max(axis=0))


def accelerations(trajectory: Trajectory) -> Array:
    """Mean acceleration between each two samples, shape (n - 1, dof) [rad/s^2]."""
    return np.asarray(np.diff(trajectory.velocities, axis=0) / np.diff(trajectory.times)[:, None])


def largest_jerk(trajectory: Trajectory) -> Array:
    """Largest change of acceleration in 1 ms, over 1 ms, of each joint, shape (dof,) [rad/s^3].

    A millisecond is the period at which such arms take commands.
    """
    times = np.arange(0.0, trajectory.duration + 0.003, 0.001)
    q = positions_at(trajectory, np.minimum(times, trajectory.duration))
    return np.asarray(np.abs(np.diff(q, n=3, axis=0)).max(axis=0) / 0.001**3)


def largest_deviation(trajectory: Trajectory, path: Array) -> float:
    """Largest distance of the sampled trajectory to the polyline [rad]."""
    return float(deviation(trajectory.positions, np.asarray(path, dtype=float)).max())
