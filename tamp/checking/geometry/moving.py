"""Loops over the poses of bodies that move, compiled: numpy would spend more on calls than on numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Indices = NDArray[np.int64]


@compiled
def centers_of(T: Array, center: Array) -> Array:
    """Where a point of a body, shape (3,), is at each of its poses T, shape (n, 4, 4): shape (n, 3)."""
    found = np.empty((len(T), 3))
    for k in range(len(T)):
        for i in range(3):
            found[k, i] = T[k, i, 0] * center[0] + T[k, i, 1] * center[1] + T[k, i, 2] * center[2] + T[k, i, 3]
    return found


@compiled
def ways(T: Array, center: Array, radius: float) -> Array:
    """Bound on the distance any point of a ball round `center` moves from each pose to the next, shape (n - 1,) [m].

    A rotation by an angle moves points of a sphere round the centre by at most 2 sin(angle / 2) radii; that chord is
    the Frobenius norm of the difference of the rotations over sqrt(2).
    """
    found = np.empty(len(T) - 1)
    for k in range(len(T) - 1):
        shift, turn = 0.0, 0.0
        for i in range(3):
            moved = T[k + 1, i, 3] - T[k, i, 3]
            for j in range(3):
                change = T[k + 1, i, j] - T[k, i, j]
                moved += change * center[j]
                turn += change * change
            shift += moved * moved
        found[k] = np.sqrt(shift) + np.sqrt(turn / 2.0) * radius
    return found


@compiled
def relative(T_a: Array, T_b: Array) -> Array:
    """The frame of b in that of a, shape (n, 4, 4), where each of them has n poses, or one and stands still."""
    n = max(len(T_a), len(T_b))
    found = np.zeros((n, 4, 4))
    for k in range(n):
        A, B = T_a[k if len(T_a) > 1 else 0], T_b[k if len(T_b) > 1 else 0]
        for i in range(3):
            for j in range(3):
                found[k, i, j] = A[0, i] * B[0, j] + A[1, i] * B[1, j] + A[2, i] * B[2, j]
                found[k, i, 3] += A[j, i] * (B[j, 3] - A[j, 3])
        found[k, 3, 3] = 1.0
    return found


@compiled
def meeting(centers: Array, radii: Array, first: Indices, second: Indices) -> NDArray[np.bool_]:
    """Which pairs of balls meet at some sample, shape (pairs,).

    Args:
        centers: shape (balls, n, 3) [m].
        radii: shape (balls,) [m].
        first: one ball of each pair, shape (pairs,).
        second: the other.
    """
    found = np.zeros(len(first), np.bool_)
    for pair in range(len(first)):
        a, b = first[pair], second[pair]
        reach = (radii[a] + radii[b]) ** 2
        for k in range(centers.shape[1]):
            apart = 0.0
            for i in range(3):
                apart += (centers[a, k, i] - centers[b, k, i]) ** 2
            if apart <= reach:
                found[pair] = True
                break
    return found


@compiled
def gaps_to_box(centers: Array, radius: float, lower: Array, upper: Array) -> Array:
    """Distances of a ball, its centres of shape (n, 3), from a box that stands still, below 0 where they meet [m]."""
    found = np.empty(len(centers))
    for k in range(len(centers)):
        apart = 0.0
        for i in range(3):
            apart += max(lower[i] - centers[k, i], centers[k, i] - upper[i], 0.0) ** 2
        found[k] = np.sqrt(apart) - radius
    return found


@compiled
def advanced(
    k: int, T: Array, gaps: Array, path: Array, allowed: float, far: float, normal: Array, corners: tuple[Array, Array]
) -> int:
    """How far a body comes past another one without a look at their shapes: conservative advancement (Mirtich 1996).

    A pair apart by d cannot touch before it has moved by d. That it is so far apart is known from `gaps`, or where the
    plane that once parted the two still does.

    Args:
        k: the sample to begin with.
        T: the frame of b in that of a at each sample, shape (n, 4, 4).
        gaps: lower bounds of the distances, shape (n,) [m].
        path: how far any point of b has moved up to each sample, shape (n,) [m].
        allowed: how deep they may be in each other [m].
        far: from which gap on the plane is not asked [m].
        normal: of the plane, from a to b, in the frame of a, shape (3,); zeros where there is none.
        corners: of the hulls of a and b in their own frames, shape (m, 3) each.

    Returns:
        The first sample at which neither says enough; n where there is none.
    """
    behind = -_lowest(corners[0], -normal)
    turned = np.empty(3)
    while k < len(T):
        room = gaps[k]
        if room < far:
            offset = -behind
            for i in range(3):
                turned[i] = normal[0] * T[k, 0, i] + normal[1] * T[k, 1, i] + normal[2] * T[k, 2, i]
                offset += normal[i] * T[k, i, 3]
            room = _lowest(corners[1], turned) + offset
            if room <= 0.0:
                return k
        k = max(k + 1, np.searchsorted(path, path[k] + room + allowed, side="right"))
    return k


@compiled
def _lowest(corners: Array, direction: Array) -> float:
    """How far the first of some corners, shape (m, 3), is along a direction."""
    least = np.inf
    for corner in corners:
        least = min(least, corner[0] * direction[0] + corner[1] * direction[1] + corner[2] * direction[2])
    return least
