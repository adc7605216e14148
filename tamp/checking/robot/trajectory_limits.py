"""Is a trajectory one that the joints can follow? Limits and smoothness of its cubic Hermite curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.robot.cubic import accelerations, extremes

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Trajectory
    from tamp.task.robot import RobotSpec

    Array = NDArray[np.float64]

LONGEST = 1e6
"""What takes longer is no motion [s]: its square may be no number, and then nobody sees what moves in between."""
SHORTEST = 1e-6
"""Samples nearer to each other are none [s]: rounding leaves no times in between at which anybody could look."""


def malformed(trajectory: Trajectory, spec: RobotSpec) -> str | None:
    """Why arrays are no trajectory of this robot at all, or None."""
    n, joints = len(trajectory.times), len(spec.joints)
    if n < 2 or trajectory.times.shape != (n,):
        return f"its times are an array of shape {trajectory.times.shape}, not a list of at least two"
    for name in ("positions", "velocities"):
        if getattr(trajectory, name).shape != (n, joints):
            return f"its {name} have shape {getattr(trajectory, name).shape}, expected {(n, joints)}"
    if not all(np.isfinite(a).all() for a in (trajectory.times, trajectory.positions, trajectory.velocities)):
        return "it holds numbers that are not finite"
    if trajectory.times[0] != 0.0 or (np.diff(trajectory.times) <= 0.0).any():
        return "its times do not increase strictly from 0"
    if np.diff(trajectory.times).min() < SHORTEST:
        return f"two of its samples are less than {SHORTEST:g} s apart"
    if trajectory.times[-1] > LONGEST:
        return f"it takes longer than {LONGEST:,.0f} s"
    return None


def violations(trajectory: Trajectory, spec: RobotSpec, allow: Tolerances) -> Iterator[tuple[float, str]]:
    """Time [s] and sentence of each limit that a well-formed trajectory breaks; the worst place of each kind.

    Judged is the cubic Hermite curve itself, at the samples and between them: the extremes of its positions and
    velocities, its accelerations, which are largest at the ends of a span, and its jerk, which is constant in a span.
    Where two spans meet, and at both ends, the acceleration jumps in all by no more in one command period than a motion
    at the limit of jerk changes it.
    """
    t, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    lowest, highest, fastest = extremes(trajectory)
    lower, upper = np.array(spec.lower), np.array(spec.upper)
    outside = np.maximum(np.maximum(lower - q, q - upper)[:-1], np.maximum(lower - lowest, highest - upper))
    last = np.maximum(lower - q[-1:], q[-1:] - upper)
    yield from _worst(np.vstack([outside, last]), allow.joint, t, spec, "is {0:.4f} rad outside its position limits")
    for what, found, limit, most in (
        ("velocity", fastest, spec.velocity, allow.velocity),
        ("acceleration", np.abs(accelerations(trajectory)).max(axis=0), spec.acceleration, allow.acceleration),
        ("jerk", np.abs(_jerks(trajectory)), spec.jerk, allow.jerk),
    ):
        yield from _worst(found / np.array(limit) - 1, most, t, spec, f"exceeds its {what} limit by {{0:.1%}}")
    jumps = _jumps(trajectory, allow.period) / (np.array(spec.jerk) * allow.period)
    yield from _worst(jumps - 1, allow.jerk, t, spec, "exceeds its jerk limit by {0:.1%} where spans meet")
    for index, moment in ((0, "starts"), (-1, "ends")):
        if (speed := float(np.abs(v[index]).max())) > allow.rest:
            yield float(t[index]), f"the motion {moment} at {speed:.3f} rad/s, not at rest"


def _jerks(trajectory: Trajectory) -> Array:
    """Jerk of the cubic in each span, shape (n - 1, joints)."""
    start, end = accelerations(trajectory)
    jerks: Array = (end - start) / np.diff(trajectory.times)[:, None]
    return jerks


def _jumps(trajectory: Trajectory, period: float) -> Array:
    """By how much accelerations jump from each sample on within a period, in all, shape (n, joints) [rad/s^2]."""
    start, end = accelerations(trajectory)
    still = np.zeros((1, start.shape[1]))
    jumps = np.abs(np.vstack([start, still]) - np.vstack([still, end]))
    until = np.searchsorted(trajectory.times, trajectory.times + period, side="right")
    total = np.concatenate([still, np.cumsum(jumps, axis=0)])
    within: Array = total[until] - total[:-1]
    return within


def _worst(excess: Array, allowed: float, t: Array, spec: RobotSpec, text: str) -> Iterator[tuple[float, str]]:
    row, joint = np.unravel_index(int(np.argmax(excess)), excess.shape)
    if not excess[row, joint] <= allowed:  # what is not a number is no better than too much
        yield float(t[row]), f"joint {spec.joints[joint]} " + text.format(float(excess[row, joint]))
