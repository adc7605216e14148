"""The measure of OCRTOC's programs since 2024: how far an object's oriented bounding box overlaps the one at its goal.

An object is in place where intersection over union is above 0.8. Symmetry is not considered.
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import bounds, convex_hull

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.model import Object, Shape
    from tamp.task.pose import Pose

    Array = NDArray[np.float64]

IN_PLACE = 0.8
"""OCRTOC's threshold of intersection over union."""

THRESHOLDS = (0.5, 0.6, 0.7, 0.8, 0.9)
"""What the share of objects in place is also told for."""

_TOLERANCE = 1e-9


def overlap_error(thing: Object, solution: Pose, goal: Pose) -> float:
    """1 - intersection over union of the bounding box in two poses: 0 for the same place, 1 for boxes apart."""
    return 1.0 - intersection_over_union(thing.shape, solution, goal)


def intersection_over_union(shape: Shape, a: Pose, b: Pose) -> float:
    """Shared volume of the shape's bounding box in two poses, as a share of the volume of both together."""
    lower, upper = bounds(shape)
    volume = float(np.prod(upper - lower))
    shared = min(volume, _shared_volume(_half_spaces(lower, upper, a), _half_spaces(lower, upper, b)))
    return shared / (2 * volume - shared)


def _half_spaces(lower: Array, upper: Array, pose: Pose) -> tuple[Array, Array]:
    """The box as points x with N x <= d: normals of shape (6, 3) and offsets of shape (6,) [m], in the world frame."""
    T = pose.matrix
    normals = np.concatenate([T[:3, :3].T, -T[:3, :3].T])
    return normals, np.concatenate([upper, -lower]) + normals @ T[:3, 3]


def _shared_volume(a: tuple[Array, Array], b: tuple[Array, Array]) -> float:
    """Volume of the intersection: its vertices are the points where three of the twelve planes meet inside all."""
    normals, offsets = np.concatenate([a[0], b[0]]), np.concatenate([a[1], b[1]])
    triples = np.array(list(combinations(range(12), 3)))
    p, q, r = (normals[triples[:, i]] for i in range(3))
    meet = np.abs(np.einsum("ij,ij->i", p, np.cross(q, r))) > _TOLERANCE
    points = np.linalg.solve(normals[triples[meet]], offsets[triples[meet]][..., None])[..., 0]
    points = points[(points @ normals.T <= offsets + _TOLERANCE).all(axis=1)]
    try:
        hull = convex_hull(points)
    except ValueError:
        return 0.0  # apart, or touching in a face, an edge or a point
    p, q, r = (hull.vertices[hull.faces[:, i]] - hull.vertices[0] for i in range(3))
    return float(np.einsum("ij,ij->i", p, np.cross(q, r)).sum() / 6)
