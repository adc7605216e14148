"""Points on the surface of a union of convex parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.geometry.half_spaces import half_spaces

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part

TYPICAL = 160  # points that stand for a surface


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points outside on a union of parts, with outward normals, (n, 3), and the area each stands for [m^2]."""

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    area: float

    def at(self, index: NDArray[np.bool_]) -> SurfacePoints:
        """Those where a mask holds."""
        return SurfacePoints(self.points[index], self.normals[index], self.area)


def surface_points(parts: Sequence[Part], count: int, rng: np.random.Generator) -> SurfacePoints:
    """Sample about `count` points uniformly by area; those hidden inside other parts are dropped."""
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    middles = np.concatenate([np.repeat(part.vertices.mean(0)[None], len(part.faces), 0) for part in parts])
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(crosses, axis=1)
    chosen = rng.choice(len(areas), size=count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    flipped = u + v > 1
    u, v = np.where(flipped, 1 - u, u), np.where(flipped, 1 - v, v)
    first, second, third = corners[chosen].transpose(1, 0, 2)
    points = first + u[:, None] * (second - first) + v[:, None] * (third - first)
    normals = crosses[chosen] / (2 * areas[chosen, None])
    outward = np.einsum("ij,ij->i", normals, points - middles[chosen])
    normals = np.where(outward[:, None] < 0, -normals, normals)
    hidden = np.zeros(count, bool)
    for part in parts:
        A, b = half_spaces(part)
        lower, upper = part.vertices.min(axis=0), part.vertices.max(axis=0)
        near = np.flatnonzero(~hidden & ((points > lower) & (points < upper)).all(axis=1))
        hidden[near] = (points[near] @ A.T - b).max(axis=1) < -1e-4
    return SurfacePoints(points[~hidden], normals[~hidden], float(areas.sum()) / count)


@lru_cache(maxsize=512)
def typical_points(parts: tuple[Part, ...]) -> NDArray[np.float64]:
    """Points on the surface of a union of parts, shape (n, 3), read-only; the same for every seed."""
    points = surface_points(parts, TYPICAL, np.random.default_rng(0)).points
    points.setflags(write=False)
    return points
