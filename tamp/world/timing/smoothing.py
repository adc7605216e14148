"""Bounded jerk: a trajectory whose accelerations jump becomes its moving average over a few milliseconds.

The average of motions within limits of position, velocity and acceleration is within them, and its acceleration grows
by no more than the range of accelerations over the window's length (Biagiotti and Melchiorri, "FIR filters for online
trajectory planning with time- and frequency-domain specifications", Control Engineering Practice 20(12), 2012). It
takes longer by the window, and leaves the path by at most acceleration * window^2 / 24, some microradians.
"""

from __future__ import annotations

import numpy as np

from tamp.compiled import compiled
from tamp.task.plan import Trajectory
from tamp.world.motion.paths import Array
from tamp.world.timing.trajectory import positions_at

SPARE = 1.001
"""Share by which the window is longer than limits of jerk ask for."""
EVEN = 1e-3
"""Share of a joint's largest acceleration by which it may jump between two samples and count as even."""
APART = 2e-4
"""Samples nearer to each other than this are one [s]."""


def smoothed(trajectory: Trajectory, jerk: Array) -> Trajectory:
    """The moving average of a trajectory from rest to rest over the shortest window that keeps limits of jerk.

    Args:
        trajectory: cubic Hermite curves between samples.
        jerk: limit of each joint, shape (dof,) [rad/s^3].
    """
    start, end = span_accelerations(trajectory)
    still = np.zeros((1, start.shape[1]))
    every = np.vstack([still, start, end])
    window = SPARE * float((np.ptp(every, axis=0) / jerk).max())
    if window < APART:
        return trajectory
    jumps = np.abs(np.vstack([start, still]) - np.vstack([still, end]))
    uneven = (jumps > EVEN * np.abs(every).max(axis=0)).any(axis=1)
    t = trajectory.times
    times = np.unique(np.concatenate([t[uneven], t[uneven] + window, t[~uneven] + window / 2]))
    last = t[-1] + window
    times = np.array([0.0, *(time for time in _apart(times) if APART < time < last - APART), last])
    before = times - window
    positions = trajectory.positions[0] + (_integral(trajectory, times) - _integral(trajectory, before)) / window
    velocities = (_at(trajectory, times) - _at(trajectory, before)) / window
    positions[[0, -1]], velocities[[0, -1]] = trajectory.positions[[0, -1]], 0.0
    return Trajectory(times, positions, velocities)


def span_accelerations(trajectory: Trajectory) -> tuple[Array, Array]:
    """Accelerations of the cubic at both ends of each span, each of shape (n - 1, dof) [rad/s^2]."""
    h, v = np.diff(trajectory.times)[:, None], trajectory.velocities
    mean = np.diff(trajectory.positions, axis=0) / h
    return (6 * mean - 4 * v[:-1] - 2 * v[1:]) / h, (-6 * mean + 2 * v[:-1] + 4 * v[1:]) / h


def _apart(times: Array) -> Array:
    """Times in ascending order, without those that follow another too closely."""
    return np.asarray(times[np.concatenate([[True], np.diff(times) > APART])])


def _at(trajectory: Trajectory, times: Array) -> Array:
    """Positions at times, at rest before the trajectory and after it."""
    return positions_at(trajectory, np.clip(times, 0.0, trajectory.duration))


def _integral(trajectory: Trajectory, times: Array) -> Array:
    """Integral of the way from the first position, from 0 to each of some times, shape (k, dof) [rad s]."""
    return _integrated(trajectory.times, trajectory.positions, trajectory.velocities, times)


@compiled
def _integrated(t: Array, q: Array, v: Array, times: Array) -> Array:
    last, dof = len(t) - 1, q.shape[1]
    upto, found = np.zeros((last + 1, dof)), np.empty((len(times), dof))
    for i in range(last):
        h = t[i + 1] - t[i]
        for j in range(dof):
            way = q[i, j] + q[i + 1, j] - 2 * q[0, j]
            upto[i + 1, j] = upto[i, j] + h * way / 2 + h * h * (v[i, j] - v[i + 1, j]) / 12
    for k in range(len(times)):
        inside = min(max(times[k], 0.0), t[last])
        i = min(max(np.searchsorted(t, inside, side="right") - 1, 0), last - 1)
        h = t[i + 1] - t[i]
        s = (inside - t[i]) / h
        for j in range(dof):
            start, way, v0, v1 = q[i, j] - q[0, j], q[i + 1, j] - q[i, j], h * v[i, j], h * v[i + 1, j]
            cubic, square = v0 + v1 - 2 * way, 3 * way - 2 * v0 - v1
            part = h * s * (start + s * (v0 / 2 + s * (square / 3 + s * cubic / 4)))
            found[k, j] = upto[i, j] + part + max(times[k] - t[last], 0.0) * (q[last, j] - q[0, j])
    return found
