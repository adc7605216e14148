"""Points that stand for the surface of a convex part."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part

    Array = NDArray[np.float64]
    Mask = NDArray[np.bool_]

SPACING = 0.006
"""Distance between the points that stand for a surface [m]."""
BEND = 0.05
"""Angle between two faces from which they meet in an edge [rad]."""


def surface_points(part: Part) -> tuple[Array, Array, Mask]:
    """Points all over the surface, the outward normals there, each of shape (n, 3), and which lie on an edge, (n,).

    A lattice on every face; an edge between two faces of about the same direction is none.
    """
    a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-14)[:, None]
    sharp = _sharp(part.faces, normals)
    longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
    count = np.clip(np.ceil(longest / SPACING).astype(np.int64), 1, 100)
    points, directions, edges = [], [], []
    for n in np.unique(count):
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
        u, v = (i[i + j <= n] / n)[:, None, None], (j[i + j <= n] / n)[:, None, None]
        chosen = count == n
        lattice = a[chosen] * (1 - u - v) + b[chosen] * u + c[chosen] * v
        points.append(lattice.reshape(-1, 3))
        directions.append(np.broadcast_to(normals[chosen], lattice.shape).reshape(-1, 3))
        on_side = np.concatenate([v < 1e-9, 1 - u - v < 1e-9, u < 1e-9], axis=2)  # ab, bc, ca
        edges.append((on_side & sharp[chosen]).any(axis=2).reshape(-1))
    return np.vstack(points), np.vstack(directions), np.concatenate(edges)


def _sharp(faces: NDArray[np.int64], normals: Array) -> Mask:
    """Whether a closed surface bends at the sides ab, bc, ca of each triangle, shape (m, 3)."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    _, pair = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    total = np.zeros((pair.max() + 1, 3))
    np.add.at(total, pair.reshape(-1), np.repeat(normals, 3, axis=0))
    # Two unit normals an angle apart add up to 2 cos(angle / 2).
    bent: Mask = np.linalg.norm(total, axis=1) < 2 * np.cos(BEND / 2)
    return bent[pair.reshape(-1)].reshape(-1, 3)
