"""Questions to a trajectory: where it is, its accelerations and jerk, how far it strays, what is in its way."""

from __future__ import annotations

from typing import Protocol

import numpy as np

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
    t, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    i = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    h = (t[i + 1] - t[i])[:, None]
    s = (np.asarray(times) - t[i])[:, None] / h
    q0, q1, v0, v1 = q[i], q[i + 1], h * v[i], h * v[i + 1]
    return np.asarray(q0 + s * (v0 + s * (3 * (q1 - q0) - 2 * v0 - v1 + s * (2 * (q0 - q1) + v0 + v1))))


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
