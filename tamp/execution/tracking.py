"""A trajectory as the motors get it: one set point a simulation step."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tamp.task import Trajectory

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def positions_at(trajectory: Trajectory, times: Array) -> Array:
    """Joint positions at `times` [s], shape (n, joints) [rad]: the cubic Hermite curve, at rest before and after."""
    knots, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    if len(knots) == 1:
        return np.repeat(q, len(times), axis=0)
    times = np.clip(times, knots[0], knots[-1])
    i = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
    h = (knots[i + 1] - knots[i])[:, None]
    s = (times - knots[i])[:, None] / h
    rest = 1 - s
    return np.asarray(
        (1 + 2 * s) * rest**2 * q[i]
        + s * rest**2 * h * v[i]
        + s**2 * (3 - 2 * s) * q[i + 1]
        - s**2 * rest * h * v[i + 1]
    )


def set_points(trajectory: Trajectory, step: float) -> tuple[Array, Array]:
    """What to send to the motors before each step of `step` seconds, both of shape (n, joints).

    The position is where the arm should be now, the velocity [rad/s] what brings it to where it should be after the
    step. So the position term acts on real errors only; asking for the later position would make the arm lead.
    """
    count = max(1, math.ceil(trajectory.duration / step - 1e-9))
    q = positions_at(trajectory, np.arange(count + 1, dtype=np.float64) * step)
    return q[:-1], np.diff(q, axis=0) / step


def backwards(trajectory: Trajectory) -> Trajectory:
    """The same motion from its end to its start."""
    end = trajectory.times[-1]
    return Trajectory(end - trajectory.times[::-1], trajectory.positions[::-1], -trajectory.velocities[::-1])
