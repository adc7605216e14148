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

    Accelerations are judged from sample to sample: the change of velocity must not ask for more than the limit, and
    the distance covered must be one that some motion within the limit covers between those two velocities. With
    a = limit * h and d = change of velocity, both over a span h, that is |distance - mean velocity * h| <=
    (a - d^2 / a) * h / 4, the value for full acceleration followed by full braking.
    """
    t, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    h = np.diff(t)[:, None]
    turn, fastest = _position_extremes(q, v, h), _velocity_extremes(q, v, h)
    lower, upper = np.array(spec.lower), np.array(spec.upper)
    outside = np.maximum(np.maximum(lower - q, q - upper)[:-1], np.maximum(lower - turn[0], turn[1] - upper))
    last = np.maximum(lower - q[-1:], q[-1:] - upper)
    yield from _worst(np.vstack([outside, last]), allow.joint, t, spec, "is {0:.4f} rad outside its position limits")
    limit = np.array(spec.velocity)
    over = np.abs(v) / limit - 1
    yield from _worst(over, allow.velocity, t, spec, "exceeds its velocity limit by {0:.1%}")
    if not (over > allow.velocity).any():
        over = fastest / limit - 1
        yield from _worst(over, allow.between, t, spec, "exceeds its velocity limit by {0:.1%} between samples")
    available = np.array(spec.acceleration) * (1 + allow.acceleration) * h + 1e-9
    change = np.abs(np.diff(v, axis=0))
    yield from _worst(
        change / (np.array(spec.acceleration) * h) - 1,
        allow.acceleration,
        t,
        spec,
        "exceeds its acceleration limit by {0:.1%}",
    )
    astray = np.abs(np.diff(q, axis=0) - (v[:-1] + v[1:]) / 2 * h)
    within = np.maximum(available - np.minimum(change, available) ** 2 / available, 0.0) * h / 4
    text = "jumps: its positions and velocities differ by {0:.5f} rad more than its acceleration limit explains"
    yield from _worst(astray - within, 1e-6, t, spec, text)
    for index, moment in ((0, "starts"), (-1, "ends")):
        if (speed := float(np.abs(v[index]).max())) > allow.rest:
            yield float(t[index]), f"the motion {moment} at {speed:.3f} rad/s, not at rest"


def _worst(excess: Array, allowed: float, t: Array, spec: RobotSpec, text: str) -> Iterator[tuple[float, str]]:
    row, joint = np.unravel_index(int(np.argmax(excess)), excess.shape)
    if excess[row, joint] > allowed:
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
