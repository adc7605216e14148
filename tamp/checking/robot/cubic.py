"""The cubic Hermite curve between the samples of a trajectory: its places, derivatives and extremes, compiled."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.plan import Trajectory

    Array = NDArray[np.float64]


def interpolate(trajectory: Trajectory, times: Array) -> Array:
    """Positions of the curve at `times`, shape (len(times), joints)."""
    return _positions(trajectory.times, trajectory.positions, trajectory.velocities, times)


def accelerations(trajectory: Trajectory) -> Array:
    """Accelerations at both ends of each span, shape (2, n - 1, joints); between them it is linear."""
    return _accelerations(trajectory.times, trajectory.positions, trajectory.velocities)


def derivatives(trajectory: Trajectory, times: Array) -> tuple[Array, Array]:
    """Absolute velocities and accelerations at both ends of the spans between `times`, each (2, n - 1, joints).

    `times` hold the trajectory's own, so that each span lies within one cubic.
    """
    t, v = trajectory.times, trajectory.velocities
    i = np.clip(np.searchsorted(t, (times[:-1] + times[1:]) / 2) - 1, 0, len(t) - 2)
    return _derivatives(t, v, accelerations(trajectory), i, times)


def extremes(trajectory: Trajectory) -> tuple[Array, Array, Array]:
    """Least position, largest position and largest absolute velocity in each span, each of shape (n - 1, joints)."""
    return _extremes(trajectory.times, trajectory.positions, trajectory.velocities)


@compiled
def _positions(t: Array, q: Array, v: Array, times: Array) -> Array:
    found = np.empty((len(times), q.shape[1]))
    for k in range(len(times)):
        i = min(max(np.searchsorted(t, times[k], side="right") - 1, 0), len(t) - 2)
        h = t[i + 1] - t[i]
        s = (times[k] - t[i]) / h
        stay, go = (1 + 2 * s) * (1 - s) ** 2, s * s * (3 - 2 * s)
        leave, come = s * (1 - s) ** 2 * h, s * s * (s - 1) * h
        for j in range(q.shape[1]):
            found[k, j] = stay * q[i, j] + leave * v[i, j] + go * q[i + 1, j] + come * v[i + 1, j]
    return found


@compiled
def _accelerations(t: Array, q: Array, v: Array) -> Array:
    found = np.empty((2, len(t) - 1, q.shape[1]))
    for k in range(len(t) - 1):
        h = t[k + 1] - t[k]
        for j in range(q.shape[1]):
            mean = (q[k + 1, j] - q[k, j]) / h
            found[0, k, j] = (6 * mean - 4 * v[k, j] - 2 * v[k + 1, j]) / h
            found[1, k, j] = (-6 * mean + 2 * v[k, j] + 4 * v[k + 1, j]) / h
    return found


@compiled
def _derivatives(t: Array, v: Array, ends: Array, spans: NDArray[np.int64], times: Array) -> tuple[Array, Array]:
    speed, growth = np.empty((2, len(spans), v.shape[1])), np.empty((2, len(spans), v.shape[1]))
    for k in range(len(spans)):
        i = spans[k]
        for side in range(2):
            since = times[k + side] - t[i]
            for j in range(v.shape[1]):
                slope = (ends[1, i, j] - ends[0, i, j]) / (t[i + 1] - t[i])
                speed[side, k, j] = abs(v[i, j] + since * (ends[0, i, j] + since * slope / 2))
                growth[side, k, j] = abs(ends[0, i, j] + since * slope)
    return speed, growth


@compiled
def _extremes(t: Array, q: Array, v: Array) -> tuple[Array, Array, Array]:
    """What is not a number stays so: numpy's minimum and maximum pass it on."""
    shape = (len(t) - 1, q.shape[1])
    low, high, fastest = np.empty(shape), np.empty(shape), np.empty(shape)
    for k in range(len(t) - 1):
        h = t[k + 1] - t[k]
        for j in range(q.shape[1]):
            mean, c = (q[k + 1, j] - q[k, j]) / h, v[k, j]
            a, b = 3 * (c + v[k + 1, j] - 2 * mean), 2 * (3 * mean - 2 * c - v[k + 1, j])  # v(s) = c + b s + a s^2
            low[k, j] = np.minimum(q[k, j], q[k + 1, j])
            high[k, j] = np.maximum(q[k, j], q[k + 1, j])
            root = np.sqrt(np.maximum(b * b - 4 * a * c, 0.0))
            for stationary in ((-b + root) / (2 * a), (-b - root) / (2 * a), -c / b):
                s = _within(stationary)
                at = q[k, j] + h * (c * s + b * s * s / 2 + a * s**3 / 3)
                low[k, j] = np.minimum(low[k, j], at)
                high[k, j] = np.maximum(high[k, j], at)
            s = _within(-b / (2 * a))
            fastest[k, j] = np.maximum(np.maximum(abs(c), abs(v[k + 1, j])), abs(c + b * s + a * s * s))
    return low, high, fastest


@compiled
def _within(share: float) -> float:
    """A share of a span, cut to it; its beginning where it is no number."""
    return min(share, 1.0) if share > 0.0 else 0.0
