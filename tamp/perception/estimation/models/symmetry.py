"""Turns that map a shape onto itself: no depth picture can tell a pose from its turned ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ALIKE_MEAN, ALIKE_WORST = 0.0025, 0.006
"""A turn maps a shape onto itself if points come this near to the shape on average, and 95 % of them that near [m]."""

DENSE = 0.005
"""What a large shape's points lie farther apart than this along its surface is no difference between shapes [m]."""

FOLDS = (2, 3, 4, 5, 6, 8)
ANY = 36
"""Turns that stand for a body of revolution."""


def symmetries(points: Array, normals: Array, center: Array) -> Array:
    """Rotations about the shape's centre that leave it where it is, shape (k, 4, 4); the identity is the first.

    Looked for about the principal axes of the surface and, where two of them are alike, about axes between them.

    Args:
        points: evenly on the surface, shape (n, 3).
        normals: at the points, shape (n, 3).
        center: their mean, shape (3,).
    """
    tree = cKDTree(np.column_stack([points, 0.004 * normals]))
    probe = slice(0, 300)
    local, facing = points[probe] - center, 0.004 * normals[probe]
    # Points never fall on points: what an identity would measure is the distance between neighbours.
    neighbours = tree.query(np.column_stack([points[probe], facing]), k=2)[0][:, 1]
    spacing = 2 * float(neighbours.mean())
    least = min(spacing, DENSE) / 4

    def holds(R: Array) -> bool:
        turned = local @ R.T + center
        distance, index = tree.query(np.column_stack([turned, facing @ R.T]))
        if spacing > DENSE:
            away = points[index] - turned
            gap = np.einsum("ij,ij->i", away, normals[index])
            along = np.linalg.norm(away - gap[:, None] * normals[index], axis=1)
            turn = np.linalg.norm(facing @ R.T - 0.004 * normals[index], axis=1)
            distance = np.sqrt(gap**2 + turn**2 + np.maximum(0.0, along - (spacing - DENSE)) ** 2)
        return bool(distance.mean() < least + ALIKE_MEAN and np.percentile(distance, 95) < ALIKE_WORST)

    found = [np.eye(3)]
    main, others = _axes(points - center)
    around = _turns_about(main, holds)
    found += around
    if len(around) == ANY - 1 and all(holds(rotation(axis, angle)) for axis in others[::9] for angle in (1.0, 2.2)):
        return np.stack([about(R, center) for R in _all_turns(main, others)])
    flips = [R for axis in others if holds(R := rotation(axis, np.pi))]
    if flips:
        found += [flips[0] @ R for R in [np.eye(3), *around]]
    else:
        found += [R for axis in others for R in _turns_about(axis, holds) if not around]
    return np.stack([about(R, center) for R in found])


def round_axes(turns: Array) -> Array:
    """Axes about which any turn maps a shape onto itself, told by its `symmetries` (k, 4, 4): none, one, or three."""
    if len(turns) < ANY:
        return np.empty((0, 3))
    if len(turns) > 2 * ANY:
        return np.eye(3)
    R = turns[1, :3, :3]  # about the main axis, see `symmetries`
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.asarray(axis[None] / np.linalg.norm(axis))


def _axes(local: Array) -> tuple[Array, list[Array]]:
    """The axis most likely to have many turns, and others perpendicular to it."""
    values, vectors = np.linalg.eigh(np.cov(local.T))
    gaps = np.abs(np.diff(values))
    single = 0 if gaps[0] > gaps[1] else 2
    main = vectors[:, single]
    a, b = (vectors[:, i] for i in range(3) if i != single)
    angles = np.arange(0, np.pi, np.pi / ANY)
    return main, [np.cos(t) * a + np.sin(t) * b for t in angles]


def _turns_about(axis: Array, holds: Any) -> list[Array]:
    """All turns about an axis that hold, without the identity."""
    if holds(rotation(axis, 1.0)) and holds(rotation(axis, 2.2)):
        return [rotation(axis, 2 * np.pi * i / ANY) for i in range(1, ANY)]
    fold = max((n for n in FOLDS if holds(rotation(axis, 2 * np.pi / n))), default=1)
    return [rotation(axis, 2 * np.pi * i / fold) for i in range(1, fold)]


def _all_turns(main: Array, others: list[Array]) -> list[Array]:
    """Turns that stand for those of a ball, 20 degrees apart: tilts in all directions, then about the axis."""
    own = [rotation(main, np.radians(20) * i) for i in range(18)]
    tilts = [np.eye(3)]
    for tilt in np.radians(np.arange(20, 181, 20)):
        count = max(1, round(18 * np.sin(tilt)))
        ways = [others[(2 * ANY * k // count) % ANY] * (1 if 2 * k < count else -1) for k in range(count)]
        tilts += [rotation(way, tilt) for way in ways]
    return [T @ R for T in tilts for R in own]


def about(R: Array, center: Array) -> Array:
    """A rotation (3, 3) about a point (3,), shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, center - R @ center
    return T
