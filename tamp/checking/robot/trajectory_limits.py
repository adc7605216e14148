"""Is a trajectory one that the joints can follow? Limits and smoothness of its cubic Hermite curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Trajectory
    from tamp.task.robot import RobotSpec

    Array = NDArray[np.float64]


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
    return None


def violations(trajectory: Trajectory, spec: RobotSpec, allow: Tolerances) -> Iterator[tuple[float, str]]:
    """Time [s] and sentence of each limit that a well-formed trajectory breaks; the worst place of each kind.

    Judged is the cubic Hermite curve itself, at the samples and between them: the extremes of its positions and
    velocities, its accelerations, which are largest at the ends of a span, and its jerk, which is constant in a span.
    Where two spans meet, and at both ends, the acceleration jumps in all by no more in one command period than a motion
    at the limit of jerk changes it.
    """
    t, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    h = np.diff(t)[:, None]
    turn, fastest = _position_extremes(q, v, h), _velocity_extremes(q, v, h)
    lower, upper = np.array(spec.lower), np.array(spec.upper)
    outside = np.maximum(np.maximum(lower - q, q - upper)[:-1], np.maximum(lower - turn[0], turn[1] - upper))
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


def accelerations(trajectory: Trajectory) -> Array:
    """Accelerations of the cubic at both ends of each span, shape (2, n - 1, joints); between them it is linear."""
    v, h = trajectory.velocities, np.diff(trajectory.times)[:, None]
    mean = np.diff(trajectory.positions, axis=0) / h
    ends: Array = np.stack([6 * mean - 4 * v[:-1] - 2 * v[1:], -6 * mean + 2 * v[:-1] + 4 * v[1:]]) / h
    return ends


def derivatives(trajectory: Trajectory, times: Array) -> tuple[Array, Array]:
    """Absolute velocities and accelerations at both ends of the spans between `times`, each (2, n - 1, joints).

    `times` hold the trajectory's own, so that each span lies within one cubic.
    """
    t, v = trajectory.times, trajectory.velocities
    i = np.clip(np.searchsorted(t, (times[:-1] + times[1:]) / 2) - 1, 0, len(t) - 2)
    start, end = accelerations(trajectory)
    slope = ((end - start) / np.diff(t)[:, None])[i]
    since = np.stack([times[:-1] - t[i], times[1:] - t[i]])[..., None]
    return np.abs(v[i] + since * (start[i] + since * slope / 2)), np.abs(start[i] + since * slope)


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


def _velocity_extremes(q: Array, v: Array, h: Array) -> Array:
    """Largest absolute velocity of the cubic in each span, shape (n - 1, joints)."""
    mean = np.diff(q, axis=0) / h
    a, b = 3 * (v[:-1] + v[1:] - 2 * mean), 2 * (3 * mean - 2 * v[:-1] - v[1:])  # v(s) = v0 + b s + a s^2
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.nan_to_num(np.clip(-b / (2 * a), 0.0, 1.0))
    largest: Array = np.maximum.reduce([np.abs(v[:-1]), np.abs(v[1:]), np.abs(v[:-1] + b * s + a * s * s)])
    return largest


def _position_extremes(q: Array, v: Array, h: Array) -> tuple[Array, Array]:
    """Least and largest position of the cubic in each span, each of shape (n - 1, joints)."""
    mean = np.diff(q, axis=0) / h
    a, b, c = 3 * (v[:-1] + v[1:] - 2 * mean), 2 * (3 * mean - 2 * v[:-1] - v[1:]), v[:-1]
    low, high = np.minimum(q[:-1], q[1:]), np.maximum(q[:-1], q[1:])
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(np.maximum(b * b - 4 * a * c, 0.0))
        stationary = [(-b + root) / (2 * a), (-b - root) / (2 * a), -c / b]
    for s in stationary:
        s = np.nan_to_num(np.clip(s, 0.0, 1.0))
        at = q[:-1] + h * (c * s + b * s * s / 2 + a * s**3 / 3)
        low, high = np.minimum(low, at), np.maximum(high, at)
    return low, high


def interpolate(trajectory: Trajectory, times: Array) -> Array:
    """Positions of the cubic Hermite curve at `times`, shape (len(times), joints)."""
    t, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    i = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    h = (t[i + 1] - t[i])[:, None]
    s = (times - t[i])[:, None] / h
    at: Array = (
        (1 + 2 * s) * (1 - s) ** 2 * q[i]
        + s * (1 - s) ** 2 * h * v[i]
        + s * s * (3 - 2 * s) * q[i + 1]
        + s * s * (s - 1) * h * v[i + 1]
    )
    return at
