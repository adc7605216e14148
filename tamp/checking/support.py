"""What does an object stand on, and does it stay there? Contact points, support polygon, centre of mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.solids import inverse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.solids import Piece, Solid

    Array = NDArray[np.float64]

BESIDE = 2e-4
"""How far beside a carrying face a point still counts as over it [m]."""
UPWARD = 0.2
"""Least vertical component of a contact normal that carries weight: walls up to 78 degrees do not."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """Where a body is carried: for each carrying body the points, shape (n, 3), in the world frame."""

    points: Mapping[str, Array]

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that carry, sorted."""
        return tuple(sorted(self.points))

    def balance(self, center: Array) -> float:
        """How far the centre of mass, seen from above, lies inside the support polygon [m]; negative outside."""
        if not self.points:
            return -np.inf
        flat = np.concatenate(list(self.points.values()))[:, :2] - center[:2]
        return _inside(flat)


def contacts(solid: Solid, T: Array, others: Mapping[str, tuple[Solid, Array]], gap: float) -> Contacts:
    """The points at which other bodies carry a body from below.

    Surface points of either body that are nearer than `gap` to the other are contacts; the normal is that of the face
    they are nearest to. Points, not fcl's contacts, because fcl names one point a pair and a polygon needs all.

    Args:
        solid: the body.
        T: where it is, T_world_body, shape (4, 4).
        others: name -> (solid, T_world_other) of the bodies that may carry it.
        gap: largest distance that counts as contact [m].
    """
    found = {}
    for name, (other, T_other) in others.items():
        T_other_body = inverse(T_other) @ T
        reach = np.linalg.norm(T_other_body[:3, :3] @ solid.center + T_other_body[:3, 3] - other.center)
        if reach > solid.radius + other.radius + gap:
            continue
        onto = _near(solid, other, T_other_body, gap, T_other[2, :3], 1.0)
        under = _near(other, solid, inverse(T_other_body), gap, T[2, :3], -1.0)
        points = np.vstack([_world(onto, T_other), _world(under, T)])
        if len(points):
            found[name] = points
    return Contacts(found)


def _world(points: Array, T: Array) -> Array:
    moved: Array = points @ T[:3, :3].T + T[:3, 3]
    return moved


def _near(body: Solid, other: Solid, T_other_body: Array, gap: float, up: Array, sign: float) -> Array:
    """Surface points of `body` that look down (sign 1) or up (-1) where faces of `other` look back at them.

    Points in the frame of `other`, shape (n, 3); `up` is the world's vertical in that frame.
    """
    kept: list[Array] = []
    up_in_body = T_other_body[:3, :3].T @ up
    for a in body.pieces:
        center = T_other_body[:3, :3] @ a.center + T_other_body[:3, 3]
        reach = np.flatnonzero(np.linalg.norm(other.centers - center, axis=1) < other.radii + a.radius + gap)
        if not len(reach):
            continue
        surface, directions = a.surface
        facing = _world(surface[sign * (directions @ up_in_body) <= -UPWARD], T_other_body)
        kept += [_over(facing, other.pieces[j], gap, sign * up) for j in reach]
    return np.vstack(kept) if kept else np.zeros((0, 3))


def _over(points: Array, piece: Piece, gap: float, up: Array) -> Array:
    """Those points that lie within `gap` of faces of a piece that look along `up`, and over them."""
    low, high = piece.part.vertices.min(axis=0) - gap, piece.part.vertices.max(axis=0) + gap
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    if not len(points):
        return points
    normals, offsets = piece.planes
    height = points @ normals.T - offsets
    carries = normals @ up >= UPWARD
    beside = height[:, ~carries].max(axis=1, initial=-np.inf)
    above = height[:, carries].max(axis=1, initial=-np.inf)
    kept: Array = points[(above <= gap) & (above >= -2 * gap) & (beside <= BESIDE)]
    return kept


def _inside(points: Array) -> float:
    """Signed distance of the origin from the convex hull of points in the plane; positive inside.

    The hull holds the origin by a margin m just if for every direction some point lies at least m that way; directions
    worth asking are the normals of the hull's edges, which a fine fan of directions stands for.
    """
    angle = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    fan = np.stack([np.cos(angle), np.sin(angle)])
    return float((points @ fan).max(axis=0).min())
