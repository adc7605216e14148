"""How fast a path may be followed where: reachability analysis under velocity and acceleration limits (TOPP-RA).

Pham and Pham, "A new approach to time-optimal path parameterization based on reachability analysis", IEEE Transactions
on Robotics 34(3), 2018. With x the square of the path's rate ds/dt and u = d2s/dt2, which is constant between two
points of the grid, limits are linear in u and x, and so is what follows: x + 2 u ds at the next point.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from tamp.world.motion.paths import Array
    from tamp.world.timing.blending import RoundedPath

FLAT = 1e-12
"""What is smaller does not depend on u."""

ROUNDS = 100
"""More steps than Newton's method ever takes, whose limits are a few dozen lines."""


def fastest_rates(curve: RoundedPath, grid: Array, velocity: Array, acceleration: Array) -> Array:
    """The path's fastest rate ds/dt at each point of the grid, zero at both ends.

    Between two points of the grid d2s/dt2 and the curve's second derivative are constant, so a limit that holds at
    both ends of an interval holds within.

    Args:
        curve: the path.
        grid: shape (m,), increasing arc lengths from one end of the curve to the other [rad].
        velocity: shape (dof,), largest velocities [rad/s].
        acceleration: shape (dof,), largest accelerations [rad/s2].
    """
    first, second = curve(grid, 1), curve(grid, 2)
    most = (velocity / np.maximum(np.abs(first), FLAT)).min(axis=1) ** 2
    return np.sqrt(_fastest(np.diff(grid), most, first / acceleration, second / acceleration))


@compiled
def _fastest(steps: Array, most: Array, first: Array, second: Array) -> Array:
    """Largest x at each of m points from rest to rest, shape (m,): a pass backwards and one forwards.

    The pass backwards finds the largest x from which the rest of the path can be followed; all smaller ones, down to
    rest, can too. The pass forwards speeds up as much as it may below that.

    Args:
        steps: between the points, shape (m - 1,).
        most: largest x for the velocities' sake, shape (m,).
        first: the path's first derivative as a share of the largest accelerations, shape (m, dof).
        second: the same of the second.
    """
    last, dof = len(steps), first.shape[1]
    lines = np.empty((4 * dof + 2, 3))
    reach, found = np.zeros(last + 1), np.zeros(last + 1)
    for i in range(last - 1, -1, -1):
        _write(lines, i, steps, first, second, reach[i + 1])
        reach[i] = _largest(lines, most[i])
    for i in range(last):
        _write(lines, i, steps, first, second, reach[i + 1])
        upper = np.inf
        for p, q, r in lines:
            if p > FLAT:
                upper = min(upper, (r - q * found[i]) / p)
        found[i + 1] = min(max(found[i] + 2 * steps[i] * upper, 0.0), reach[i + 1])
    return found


@compiled
def _write(lines: Array, i: int, steps: Array, first: Array, second: Array, reach: float) -> None:
    """Write the limits between point i and the next one as rows p, q, r of p u + q x <= r.

    Accelerations, in shares of the largest, are at most 1 at either end, and x in [0, reach] at the next one.
    """
    row = 0
    for side in (1.0, -1.0):
        for joint in range(first.shape[1]):
            p, q = first[i, joint], second[i, joint]
            lines[row, 0], lines[row, 1], lines[row, 2] = side * p, side * q, 1.0
            p, q = first[i + 1, joint] + 2 * steps[i] * second[i + 1, joint], second[i + 1, joint]
            lines[row + 1, 0], lines[row + 1, 1], lines[row + 1, 2] = side * p, side * q, 1.0
            row += 2
        lines[row, 0], lines[row, 1], lines[row, 2] = side * 2 * steps[i], side, reach if side > 0 else 0.0
        row += 1


@compiled
def _largest(lines: Array, most: float) -> float:
    """The largest x up to `most` for which some u keeps all lines, which u = x = 0 does.

    Of u, an x leaves the range between a concave and a convex chain of lines. Newton's method goes down from an x with
    nothing between the two to where the lines that part them there meet, and never beyond the answer.
    """
    x = most
    for p, q, r in lines:
        if abs(p) <= FLAT and q > 0.0:
            x = min(x, r / q)
    for _ in range(ROUNDS):
        upper, lower = np.inf, -np.inf
        rise, fall = 0.0, 0.0
        for p, q, r in lines:
            if abs(p) > FLAT:
                u = (r - q * x) / p
                if p > 0.0 and u < upper:
                    upper, fall = u, -q / p
                if p < 0.0 and u > lower:
                    lower, rise = u, -q / p
        if upper >= lower or fall >= rise:
            break
        x = max(x - (upper - lower) / (fall - rise), 0.0)
    return x
