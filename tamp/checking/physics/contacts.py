"""What does an object touch, and what carries it? Contact points and their normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.polyhedra import looking_back
from tamp.checking.geometry.solids import parting_normal
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics import equilibrium

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.geometry.solids import Piece, Solid

    Array = NDArray[np.float64]

BESIDE = 2e-4
"""How far beside a touched face a point still counts as over it [m]."""
FACING = 0.2
"""Least cosine between a face and that of an edge which touches it: an edge's faces lean up to 78 degrees."""
PARALLEL = 0.98
"""The same for two faces that touch all over: those more than 11 degrees apart touch only where one has an edge."""
UPWARD = 0.2
"""Least vertical component of a contact normal that carries weight: walls up to 78 degrees do not."""


@dataclass(frozen=True, eq=False)
class Patch:
    """Points at which one body touches another, and unit normals into the other there, each of shape (n, 3)."""

    points: Array
    normals: Array


@dataclass(frozen=True, eq=False)
class Contacts:
    """Where a body is touched: for each other body its patch, in the world frame."""

    patches: Mapping[str, Patch]

    @property
    def points(self) -> Mapping[str, Array]:
        """For each body that carries, the points at which it does, shape (n, 3)."""
        carrying = {name: patch.points[patch.normals[:, 2] >= UPWARD] for name, patch in self.patches.items()}
        return {name: points for name, points in carrying.items() if len(points)}

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that carry, sorted."""
        return tuple(sorted(self.points))

    def without(self, *names: str) -> Contacts:
        """The contacts with all bodies but some."""
        return Contacts({other: patch for other, patch in self.patches.items() if other not in names})

    def balance(self, center: Array, friction: Mapping[str, float], wanted: float) -> float:
        """How well the body rests [m], see `equilibrium.balance`; `friction` is the coefficient with each body."""
        names = sorted(self.patches)
        points = [self.patches[name].points for name in names]
        normals = [self.patches[name].normals for name in names]
        if not names:
            return -np.inf
        mu = np.repeat([friction[name] for name in names], [len(p) for p in points])
        return equilibrium.balance(np.concatenate(points), np.concatenate(normals), mu, center, wanted)


def contacts(
    solid: Solid, T: Array, others: Mapping[str, tuple[Solid, Array]], gap: float, deep: float | None = None
) -> Contacts:
    """Where other bodies touch a body.

    Surface points of either body that are nearer than `gap` to the other are contacts; the normal is that of the face
    they are nearest to. Points, not fcl's contacts, because fcl names one point a pair and a balance needs all.

    Args:
        solid: the body.
        T: where it is, T_world_body, shape (4, 4).
        others: name -> (solid, T_world_other) of the bodies that it may touch.
        gap: largest distance that counts as contact [m].
        deep: and the largest depth; twice the gap where it is None [m].
    """
    deep, found = 2 * gap if deep is None else deep, {}
    for name, (other, T_other) in others.items():
        T_other_body = inverse(T_other) @ T
        reach = np.linalg.norm(T_other_body[:3, :3] @ solid.center + T_other_body[:3, 3] - other.center)
        if reach > solid.radius + other.radius + gap:
            continue
        onto, up = _near(solid, other, T_other_body, gap, deep)
        under, down = _near(other, solid, inverse(T_other_body), gap, deep)
        points = np.vstack([_world(onto, T_other), _world(under, T)])
        if len(points):
            found[name] = Patch(points, np.vstack([up @ T_other[:3, :3].T, -down @ T[:3, :3].T]))
    return Contacts(found)


def _world(points: Array, T: Array) -> Array:
    moved: Array = points @ T[:3, :3].T + T[:3, 3]
    return moved


def _near(body: Solid, other: Solid, T_other_body: Array, gap: float, deep: float) -> tuple[Array, Array]:
    """Surface points of `body` near faces of `other` that look back at them, and those faces' normals.

    Both in the frame of `other`, shape (n, 3).
    """
    corners, first = body.corners
    corners = _world(corners, T_other_body)
    low, high = np.minimum.reduceat(corners, first), np.maximum.reduceat(corners, first)
    lower, upper = other.boxes[0] - gap, other.boxes[1] + gap
    meeting = np.asarray(((low[:, None] <= upper) & (high[:, None] >= lower)).all(axis=2))
    points, normals = [np.zeros((0, 3))], [np.zeros((0, 3))]
    convex = len(body.pieces) == len(other.pieces) == 1
    for i in np.flatnonzero(meeting.any(axis=1)):
        near, least, asked = (gap, deep, BESIDE), (FACING, PARALLEL), np.flatnonzero(meeting[i])
        surface = body.pieces[i].surface
        over, pieces, faces = looking_back(surface, T_other_body, other.planes, (lower, upper), near, least, asked)
        points.append(over)
        normals += [
            _pushing(body.pieces[i], T_other_body, other.pieces[j], faces[pieces == j], gap, convex)
            for j in np.unique(pieces)
        ]
    return np.vstack(points), np.vstack(normals)


def _pushing(a: Piece, T: Array, b: Piece, faces: NDArray[np.int64], gap: float, convex: bool) -> Array:
    """Unit normals, shape (n, 3), along which piece `b` pushes piece `a`, at T in its frame, near some of its faces.

    Two convex bodies that touch are parted by one plane, and push each other across it alone. A face that does not part
    them gives way to the plane that does: the sides of what stands over the edge of a table may reach a little below
    its top, and the table's side does not push them for that; nor does either side of an edge carry what lies across
    it. Pieces of bodies that are not `convex` bulge, and only a face that looks quite another way gives way there.
    """
    (normals, offsets), (others, theirs) = b.planes, a.planes
    beyond = (normals @ _world(a.part.vertices, T).T).min(axis=1) - offsets
    back = (others @ _world(b.part.vertices, inverse(T)).T).min(axis=1) - theirs
    pushing, parting = normals[faces], beyond >= max(beyond.max(), back.max()) - gap
    if not parting[faces].all():
        best = parting_normal(a, b, inverse(T)) @ T[:3, :3].T
        pushing[~parting[faces] & (convex | (pushing @ best < FACING))] = best
    return pushing
