"""The error as OCRTOC 2021's own program computes it: ADD over 100 points of the surface, ADD-S for symmetric objects.

Both are of Hinterstoisser et al., "Model based training, detection and pose estimation of texture-less 3D objects in
heavily cluttered scenes", ACCV 2012. OCRTOC draws the points by Poisson disk sampling from a visual mesh, anew at every
run; here they come from the collision geometry and are always the same.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import Part, parts
from tamp.task.model import Symmetry

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.model import Object, Shape
    from tamp.task.pose import Pose

    Array = NDArray[np.float64]

BOUND_M = math.hypot(1.2, 0.6) / 2
"""No object counts for more: half the diagonal of what OCRTOC takes as its table [m]."""

POINTS = 100
CANDIDATES = 400
"""Drawn evenly from the surface, before the closest are thinned out."""

SKIN = 1e-4
"""How deep in another convex part a point lies inside the object [m]."""


def surface_error(thing: Object, solution: Pose, goal: Pose) -> float:
    """ADD, or ADD-S for an object with any symmetry, between two poses [m]."""
    points = surface_points(thing.shape)
    return (add if thing.symmetry == Symmetry() else add_s)(points, solution, goal)


def add(points: Array, solution: Pose, goal: Pose) -> float:
    """Mean distance of each point to where it should be; points of shape (n, 3) in the object's frame [m]."""
    return float(np.linalg.norm(_at(solution, points) - _at(goal, points), axis=1).mean())


def add_s(points: Array, solution: Pose, goal: Pose) -> float:
    """Mean distance of each point to the nearest place where some point should be; never above `add` [m]."""
    apart = np.linalg.norm(_at(solution, points)[:, None] - _at(goal, points)[None, :], axis=2)
    return float(apart.min(axis=1).mean())


def surface_points(shape: Shape) -> Array:
    """`POINTS` points spread over the shape's surface, shape (n, 3), in its frame [m]; always the same."""
    return _surface_points(parts(shape))


@lru_cache(maxsize=512)
def _surface_points(pieces: tuple[Part, ...]) -> Array:
    """Candidates, less those that stand closest to another, as Yuksel, "Sample elimination", CGF 2015, has it."""
    points = _candidates(pieces)
    apart = np.linalg.norm(points[:, None] - points[None, :], axis=2)
    np.fill_diagonal(apart, np.inf)
    kept = np.ones(len(points), dtype=bool)
    while kept.sum() > POINTS:
        closest = int(np.where(kept, apart.min(axis=1), np.inf).argmin())
        kept[closest] = False
        apart[closest, :] = apart[:, closest] = np.inf
    return points[kept]


def _candidates(pieces: tuple[Part, ...]) -> Array:
    """Points drawn evenly from what can be seen of the parts' surfaces, shape (`CANDIDATES`, 3) [m]."""
    rng = np.random.default_rng(0)
    triangles = np.concatenate([piece.vertices[piece.faces] for piece in pieces])
    owner = np.repeat(np.arange(len(pieces)), [len(piece.faces) for piece in pieces])
    a, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    area = np.linalg.norm(np.cross(u, v), axis=1)
    found: list[Array] = []
    while sum(map(len, found)) < CANDIDATES:
        drawn = rng.choice(len(triangles), CANDIDATES, p=area / area.sum())
        s, t = rng.random((2, CANDIDATES, 1))
        s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
        points = a[drawn] + s * u[drawn] + t * v[drawn]
        found.append(points[~_hidden(points, owner[drawn], pieces)])
    return np.concatenate(found)[:CANDIDATES]


def _hidden(points: Array, owner: NDArray[np.int64], pieces: tuple[Part, ...]) -> NDArray[np.bool_]:
    """Whether each point lies inside another part than its own, where no surface of the object is."""
    hidden = np.zeros(len(points), dtype=bool)
    for number, piece in enumerate(pieces):
        a, b, c = (piece.vertices[piece.faces[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        length = np.linalg.norm(normals, axis=1)
        solid = length > 0
        normals = normals[solid] / length[solid, None]
        height = points @ normals.T - np.einsum("ij,ij->i", normals, a[solid])
        hidden |= (owner != number) & (height.max(axis=1) < -SKIN)
    return hidden


def _at(pose: Pose, points: Array) -> Array:
    T = pose.matrix
    return points @ T[:3, :3].T + T[:3, 3]
