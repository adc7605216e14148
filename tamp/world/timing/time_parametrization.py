"""When the arm is where: a path becomes a trajectory under velocity and acceleration limits, by TOPPRA."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from tamp.task.plan import Trajectory
from tamp.task.robot import RobotSpec
from tamp.world.motion.paths import Array, without_duplicates
from tamp.world.timing.blending import RoundedPath, rounded
from tamp.world.timing.smoothing import smoothed, span_accelerations
from tamp.world.timing.trajectory import ConfigurationTest, accelerations, first_blocked, peak_velocities

SAMPLE_S = 0.02
"""Longest time between two samples of a trajectory [s]."""

SPACING = 0.019
"""The same before a trajectory that exceeds a limit by some percent is stretched [s]."""

TOLERANCE = 0.004
"""How far rounded corners may leave the polyline [rad]."""

GRID = 30
"""Number of intervals that TOPPRA divides a path into, besides the ends of its blends."""

LEAST = 4
"""The same for each straight stretch, however short."""

TESTED_EVERY = 0.01
"""How far the fastest point of arm and held object moves between two tests of a timed curve [m]."""

SLACK = 1e-3
"""Share by which a sampled trajectory may exceed a limit before it is stretched; numerical, not physical."""

ENDS = 0.01
"""The same of accelerations at the ends of its cubics: they only approximate the motion between samples."""


def time_path(path: Array, limits: RobotSpec, *, speed: float = 1.0, tolerance: float = TOLERANCE) -> Trajectory:
    """The fastest trajectory along a path, at rest at both ends, by TOPPRA (Pham and Pham, 2018).

    The corners of the path are rounded by parabolas, so that path and timing are smooth between the points at which
    TOPPRA sets the acceleration, at most SAMPLE_S apart. There it jumps, so that the motion is averaged over the few
    milliseconds in which the limits of jerk let it change. The limits hold by construction; the samples, and velocities
    between them, are verified nevertheless, and stretched in time if need be.

    Args:
        path: shape (n, dof) [rad]; duplicates are dropped. A path of no length becomes two equal samples, SAMPLE_S
            apart, at rest.
        limits: of position, velocity, acceleration and jerk; all are respected.
        speed: share of the velocity and acceleration limits to use, in (0, 1].
        tolerance: how far the trajectory may leave the polyline, at its corners [rad].

    Raises:
        ValueError: for a path of wrong shape, not finite or outside the position limits, or a speed out of range.
    """
    from tamp.world.timing.path_rates import fastest_rates  # imports TOPPRA, which takes its time

    path = _checked(path, limits, speed)
    points = without_duplicates(path)
    if len(points) == 1:
        still = np.repeat(points, 2, axis=0)
        return Trajectory(np.array([0.0, SAMPLE_S]), still, np.zeros_like(still))
    curve = rounded(points, tolerance)
    grid = _grid(curve)
    velocity, acceleration = speed * np.array(limits.velocity), speed * np.array(limits.acceleration)
    rates = fastest_rates(curve, grid, velocity, acceleration)
    trajectory = smoothed(_sample(curve, grid, rates), np.array(limits.jerk))
    ends = np.abs(span_accelerations(trajectory)).max(axis=0) / (1.0 + ENDS)
    excess = max(
        float((peak_velocities(trajectory) / velocity).max()),
        float(np.sqrt((np.abs(accelerations(trajectory)) / acceleration).max())),
        float(np.sqrt((ends / limits.acceleration).max())),
    )
    return trajectory if excess <= 1.0 + SLACK / 2 else stretched(trajectory, excess)


def stretched(trajectory: Trajectory, factor: float) -> Trajectory:
    """The same motion, slower by a factor."""
    return Trajectory(factor * trajectory.times, trajectory.positions, trajectory.velocities / factor)


@dataclass(frozen=True, eq=False)
class TimedMotion:
    """A trajectory that is free of collision, or the reason why there is none.

    Attributes:
        trajectory: None where the timed curve touches something, however closely it follows the path.
        reason: "" or one clause.
    """

    trajectory: Trajectory | None
    reason: str = ""


def time_free_path(path: Array, limits: RobotSpec, checker: ConfigurationTest, *, speed: float = 1.0) -> TimedMotion:
    """Time a path and check the timed curve at every centimetre of motion of the fastest point.

    Where the curve touches something, the path is timed again with sharper corners; the last attempt follows the
    polyline within 0.1 mrad.

    Args:
        path: shape (n, dof) [rad], free of collision.
        limits: as in `time_path`.
        checker: says which configurations are free.
        speed: as in `time_path`.
    """
    for tolerance in (TOLERANCE, TOLERANCE / 8, 1e-4):
        trajectory = time_path(path, limits, speed=speed, tolerance=tolerance)
        blocked = first_blocked(trajectory, checker, TESTED_EVERY)
        if blocked is None:
            return TimedMotion(trajectory)
    return TimedMotion(None, f"the timed motion touches something {blocked:.2f} s after its start")


def _checked(path: Array, limits: RobotSpec, speed: float) -> Array:
    path = np.asarray(path, dtype=float)
    if path.ndim != 2 or path.shape[0] < 1 or path.shape[1] != len(limits.joints):
        raise ValueError(f"a path of {limits.name} has shape (n, {len(limits.joints)}), n >= 1, not {path.shape}")
    if not np.isfinite(path).all():
        raise ValueError("the path holds numbers that are not finite")
    if not 0.0 < speed <= 1.0:
        raise ValueError(f"speed is a share of the limits in (0, 1], not {speed}")
    outside = np.argwhere((path < np.array(limits.lower) - 1e-6) | (path > np.array(limits.upper) + 1e-6))
    if outside.size:
        row, joint = outside[0]
        bounds = f"[{limits.lower[joint]:.4f}, {limits.upper[joint]:.4f}]"
        raise ValueError(f"waypoint {row} has {limits.joints[joint]} at {path[row, joint]:.4f}, beyond {bounds}")
    return path


def _grid(curve: RoundedPath) -> Array:
    """All breaks of the curve, and points between them, denser near the ends of the straight stretches.

    There the motion turns from one limit to another, and blends are short; neighbours of very different length cost
    speed.
    """
    breaks = curve.breaks
    counts = np.ceil(np.diff(breaks) / (curve.arc[-1] / GRID)).astype(int)
    pieces = []
    for k, (start, end) in enumerate(itertools.pairwise(breaks)):
        is_blend = k % 2 == 1
        count = max(counts[k], 1 if is_blend else LEAST)
        share = np.arange(count) / count
        pieces.append(start + (end - start) * (share if is_blend else (1 - np.cos(np.pi * share)) / 2))
    return np.concatenate([*pieces, breaks[-1:]])


def _sample(curve: RoundedPath, grid: Array, rates: Array) -> Trajectory:
    """Sample at every grid point and at most SPACING apart; d2s/dt2 is constant between the grid's points."""
    spans = 2 * np.diff(grid) / (rates[:-1] + rates[1:])
    counts = np.maximum(1, np.ceil(spans / SPACING - 1e-9)).astype(int)
    interval = np.repeat(np.arange(len(spans)), counts)
    share = (np.arange(len(interval)) - (np.cumsum(counts) - counts)[interval]) / counts[interval]
    elapsed = share * spans[interval]
    growth = (np.diff(rates) / spans)[interval]
    starts = np.concatenate([[0.0], np.cumsum(spans)])
    times = np.append(starts[interval] + elapsed, starts[-1])
    s = np.append(grid[interval] + elapsed * (rates[interval] + elapsed * growth / 2), grid[-1])
    rate = np.append(rates[interval] + elapsed * growth, rates[-1])
    return Trajectory(times, curve(s), curve(s, 1) * rate[:, None])
