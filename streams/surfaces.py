"""Points on the surface of a union of convex parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.world.geometry.half_spaces import half_spaces, joined

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part
    from tamp.world.geometry.half_spaces import Planes

    Array = NDArray[np.float64]

HIDDEN = 1e-4  # what is deeper than this inside a part is not seen [m]
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
    corners, crosses, planes = _faces(tuple(parts))
    areas = 0.5 * np.linalg.norm(crosses, axis=1)
    chosen = rng.choice(len(areas), size=count, p=areas / areas.sum())
    u, v = rng.random((2, count))
    flipped = u + v > 1
    u, v = np.where(flipped, 1 - u, u), np.where(flipped, 1 - v, v)
    first, second, third = corners[chosen].transpose(1, 0, 2)
    points = first + u[:, None] * (second - first) + v[:, None] * (third - first)
    normals, seen = crosses[chosen] / (2 * areas[chosen, None]), ~_hidden(points, planes)
    return SurfacePoints(points[seen], normals[seen], float(areas.sum()) / count)


@lru_cache(maxsize=512)
def _faces(parts: tuple[Part, ...]) -> tuple[Array, Array, Planes]:
    """Corners of all triangles (n, 3, 3) [m], outward normals twice as long as their areas (n, 3), and all planes."""
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    middles = np.concatenate([np.repeat(part.vertices.mean(0)[None], len(part.faces), 0) for part in parts])
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    crosses[np.einsum("ij,ij->i", crosses, corners.mean(axis=1) - middles) < 0] *= -1.0
    return corners, crosses, joined(map(half_spaces, parts))


@compiled
def _hidden(points: Array, planes: Planes) -> NDArray[np.bool_]:
    """Which points, shape (n, 3), are inside any part, shape (n,)."""
    A, b, ends = planes
    hidden = np.zeros(len(points), np.bool_)
    for k in range(len(points)):
        first = 0
        for end in ends:
            inside = True
            for m in range(first, end):
                depth = b[m] - A[m, 0] * points[k, 0] - A[m, 1] * points[k, 1] - A[m, 2] * points[k, 2]
                if depth <= HIDDEN:
                    inside = False
                    break
            first = end
            if inside:
                hidden[k] = True
                break
    return hidden


@lru_cache(maxsize=512)
def typical_points(parts: tuple[Part, ...]) -> NDArray[np.float64]:
    """Points on the surface of a union of parts, shape (n, 3), read-only; the same for every seed."""
    points = surface_points(parts, TYPICAL, np.random.default_rng(0)).points
    points.setflags(write=False)
    return points
