"""What does an object stand on, and does it stay there? Contact points, support polygon, centre of mass."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.solids import Piece, Solid

    Array = NDArray[np.float64]

SPACING = 0.006
"""Distance between the surface points that stand for a body in contact tests [m]."""
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
        solid, T: the body and T_world_body, shape (4, 4).
        others: name -> (solid, T_world_other) of the bodies that may carry it.
        gap: largest distance that counts as contact [m].
    """
    found = {}
    for name, (other, T_other) in others.items():
        T_other_body = np.linalg.inv(T_other) @ T
        reach = np.linalg.norm(T_other_body[:3, :3] @ solid.center + T_other_body[:3, 3] - other.center)
        if reach > solid.radius + other.radius + gap:
            continue
        up = T_other[2, :3]
        onto = _near(solid, other, T_other_body, gap, up, 1.0)
        under = _near(other, solid, np.linalg.inv(T_other_body), gap, T[2, :3], -1.0)
        points = np.vstack([_world(onto, T_other), _world(under, T)])
        if len(points):
            found[name] = points
    return Contacts(found)


def center_of_mass(solid: Solid) -> Array:
    """Centre of mass in the body's frame, shape (3,), of uniform pieces whose overlaps count twice."""
    volumes, centers = zip(*(_mass(piece) for piece in solid.pieces), strict=True)
    weighted: Array = np.average(np.array(centers), axis=0, weights=np.array(volumes))
    return weighted


def _world(points: Array, T: Array) -> Array:
    moved: Array = points @ T[:3, :3].T + T[:3, 3]
    return moved


def _near(body: Solid, other: Solid, T_other_body: Array, gap: float, up: Array, sign: float) -> Array:
    """Surface points of `body` within `gap` of `other` where the face of `other` looks up (sign 1) or down (-1).

    Points in the frame of `other`, shape (n, 3); `up` is the world's vertical in that frame.
    """
    kept: list[Array] = []
    for a in body.pieces:
        center = T_other_body[:3, :3] @ a.center + T_other_body[:3, 3]
        reach = np.linalg.norm(other.centers - center, axis=1) < other.radii + a.radius + gap
        for j in np.flatnonzero(reach):
            b = other.pieces[j]
            points = _world(_surface(a), T_other_body)
            low, high = b.part.vertices.min(axis=0) - gap, b.part.vertices.max(axis=0) + gap
            points = points[((points >= low) & (points <= high)).all(axis=1)]
            if not len(points):
                continue
            normals, offsets = _planes(b)
            height = points @ normals.T - offsets
            face = height.argmax(axis=1)
            near = height.max(axis=1)
            touching = (near <= gap) & (near >= -2 * gap)
            carries = sign * (normals[face] @ up) >= UPWARD
            kept.append(points[touching & carries])
    return np.vstack(kept) if kept else np.zeros((0, 3))


@lru_cache(maxsize=4096)
def _surface(piece: Piece) -> Array:
    """Points on a convex part's surface: its vertices, and a lattice on every triangle larger than the spacing."""
    a, b, c = (piece.part.vertices[piece.part.faces[:, i]] for i in range(3))
    points = [piece.part.vertices]
    longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
    count = np.clip(np.ceil(longest / SPACING).astype(int), 1, 100)
    for n in np.unique(count):
        if n == 1:
            continue
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
        u, v = (i[i + j <= n] / n)[:, None, None], (j[i + j <= n] / n)[:, None, None]
        chosen = count == n
        points.append((a[chosen] * (1 - u - v) + b[chosen] * u + c[chosen] * v).reshape(-1, 3))
    return np.vstack(points)


@lru_cache(maxsize=4096)
def _planes(piece: Piece) -> tuple[Array, Array]:
    """Outward unit normals, shape (m, 3), and offsets, shape (m,), of a convex part's faces."""
    a, b, c = (piece.part.vertices[piece.part.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    solid = length > 1e-14
    normals = normals[solid] / length[solid, None]
    return normals, np.einsum("ij,ij->i", normals, a[solid])


@lru_cache(maxsize=4096)
def _mass(piece: Piece) -> tuple[float, tuple[float, float, float]]:
    """Volume and centroid of a convex part: tetrahedra from one inner point."""
    inner = piece.part.vertices.mean(axis=0)
    a, b, c = (piece.part.vertices[piece.part.faces[:, i]] - inner for i in range(3))
    volume = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6
    x, y, z = inner + (volume[:, None] * (a + b + c) / 4).sum(axis=0) / volume.sum()
    return float(volume.sum()), (float(x), float(y), float(z))


def _inside(points: Array) -> float:
    """Signed distance of the origin from the convex hull of points in the plane; positive inside.

    The hull holds the origin by a margin m just if for every direction some point lies at least m that way; directions
    worth asking are the normals of the hull's edges, which a fine fan of directions stands for.
    """
    angle = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    fan = np.stack([np.cos(angle), np.sin(angle)])
    return float((points @ fan).max(axis=0).min())
