"""The space that an object takes up, which need not be what it looks like: scanners do not see into deep hollows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from tamp.compiled import compiled
from tamp.task.mesh.parts import Part
from tamp.world.geometry.half_spaces import half_spaces, joined

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    _Hulls = tuple[Array, Array, NDArray[np.int64]]
    """Of convex parts: boxes around them (n, 6), their planes (m, 4), where each one's end among these (n,)."""

INSIDE = 0.004
"""Less deep is touching [m]."""

AROUND = 8
"""Points of a surface that must agree that a place is inside it: of a thin wall the other side may be the nearest."""

REACH = 0.03
"""Places farther from the surface than this are not looked at [m]."""

SPACING = 0.006
"""Points on the surface of convex parts are about this far apart [m]."""

JOINT = 0.001
"""What lies so far before a part's face in another part shows that the face is inside the object [m]."""


@dataclass(frozen=True, eq=False)
class Occupancy:
    """Oriented points on the surface of what an object takes up, in its own frame, and its convex parts where known.

    Attributes:
        points, normals: on the surface, normals outwards, shape (n, 3); any prefix is spread over all of it.
        solid: whether there is matter behind a point, shape (n,).
        area: of the surface [m^2].
        parts: convex parts; without any, the points alone say what is inside.
    """

    points: Array
    normals: Array
    solid: NDArray[np.bool_]
    area: float
    parts: tuple[Part, ...] = ()

    @cached_property
    def _tree(self) -> Any:
        return cKDTree(self.points)

    @cached_property
    def _hulls(self) -> _Hulls:
        return _hulls(self.parts)

    def inside(self, points: Array) -> NDArray[np.bool_]:
        """Which points, shape (n, 3) in the object's frame, are deeper than touching inside the object."""
        found = _within(points, *self._hulls) if self.parts else np.ones(len(points), dtype=np.bool_)
        some = np.flatnonzero(found)
        found[some] = self._behind(points[some])
        return found

    def _behind(self, points: Array) -> NDArray[np.bool_]:
        """Which points, shape (n, 3), are deeper than touching behind the surface that is nearest to them."""
        found = np.zeros(len(points), dtype=np.bool_)
        if not len(points):
            return found
        distance, index = self._tree.query(points, k=1 if self.parts else AROUND, distance_upper_bound=REACH)
        distance, index = distance.reshape(len(points), -1), index.reshape(len(points), -1)
        near = np.flatnonzero(np.isfinite(distance[:, 0]))
        distance, index = distance[near], index[near]
        index = np.where(np.isfinite(distance), index, index[:, :1])
        depth = np.einsum("nkj,nkj->nk", self.points[index] - points[near, None], self.normals[index])
        deep = (depth[:, 0] > INSIDE) & (depth[:, 0] > 0.7 * distance[:, 0]) & self.solid[index[:, 0]]
        found[near] = deep & (depth > 0).all(axis=1)
        return found


def occupancy_of_parts(parts: Sequence[Part]) -> Occupancy:
    """The space of convex parts; faces of one that lie inside another are none of its surface."""
    rng = np.random.default_rng(0)
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(crosses, axis=1) / 2
    count = max(1, int(areas.sum() / SPACING**2))
    # Evenly along the summed area, in random order: any prefix is spread over all of the surface.
    chosen = np.searchsorted(np.cumsum(areas), areas.sum() * (rng.permutation(count) + rng.random(count)) / count)
    chosen = np.minimum(chosen, len(areas) - 1)
    u, v = rng.random((2, count))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    points = np.einsum("nij,ni->nj", corners[chosen], np.stack([1 - u - v, u, v], axis=1))
    normals = crosses[chosen] / (2 * areas[chosen, None])
    outer = ~_within(points + JOINT * normals, *_hulls(parts))
    points, normals = points[outer], normals[outer]
    return Occupancy(points, normals, np.ones(len(points), np.bool_), float(areas.sum()) * outer.mean(), tuple(parts))


def _hulls(parts: Sequence[Part]) -> _Hulls:
    A, b, ends = joined(half_spaces(part) for part in parts)
    corners = [np.concatenate([part.vertices.min(axis=0), part.vertices.max(axis=0)]) for part in parts]
    return np.array(corners), np.column_stack([A, b]), ends


@compiled
def _within(points: Array, boxes: Array, planes: Array, ends: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which points, shape (n, 3), are in any of some convex parts."""
    found = np.zeros(len(points), dtype=np.bool_)
    around = np.empty(6)
    for axis in range(3):
        around[axis], around[axis + 3] = boxes[:, axis].min(), boxes[:, axis + 3].max()
    for n in range(len(points)):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        if not (around[0] <= x <= around[3] and around[1] <= y <= around[4] and around[2] <= z <= around[5]):
            continue
        for part in range(len(ends)):
            if not (boxes[part, 0] <= x <= boxes[part, 3] and boxes[part, 1] <= y <= boxes[part, 4]):
                continue
            if not boxes[part, 2] <= z <= boxes[part, 5]:
                continue
            inside = True
            for m in range(ends[part - 1] if part else 0, ends[part]):
                if planes[m, 0] * x + planes[m, 1] * y + planes[m, 2] * z > planes[m, 3]:
                    inside = False
                    break
            if inside:
                found[n] = True
                break
    return found


def shared(a: Occupancy, b: Occupancy, T_b_a: Array, probes: int = 400) -> float:
    """How much of a's surface is inside b, where a lies at T_b_a (4, 4) in b's frame [m^2]."""
    points = a.points[:probes] @ T_b_a[:3, :3].T + T_b_a[:3, 3]
    return float(b.inside(points).mean()) * a.area
