"""The support function of a cloud of points: how far it reaches in a direction, for very many directions.

On the edges of a convex polytope a linear function has no local maximum but the global one, so that a climb from vertex
to vertex finds it (Ericson, Real-Time Collision Detection, 2005, section 9.5.4). Climbs begin at the facet of the hull
that faces the direction best, so that they are short, however many points there are.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import ConvexHull, QhullError, cKDTree

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Points = NDArray[np.float64]

FEW = 64
"""So many points are all looked at; of more, where that will do, those that lie farthest in so many directions."""
BLOCK = 1 << 20
"""Heights at a time."""


class Support:
    """How far points reach.

    Args:
        points: shape (n, 3), n > 0 [m].
    """

    def __init__(self, points: Points) -> None:
        self._points = points
        self._first = points if len(points) <= FEW else points[np.unique((_spread(FEW) @ points.T).argmax(axis=1))]

    def at_least(self, directions: Points) -> NDArray[np.float64]:
        """How far some of the points reach in directions, shape (m, 3) -> (m,) [m]: nowhere farther than all do."""
        return _farthest(self._first, directions)[1]

    def exactly(self, directions: Points) -> NDArray[np.float64]:
        """How far the points reach in directions, shape (m, 3) -> (m,) [m]."""
        if len(self._points) <= FEW:
            return self.at_least(directions)
        if self._polytope is None:  # flat: it has no edges to climb along
            return _farthest(self._points, directions)[1]
        vertices, neighbours, normals, corner = self._polytope
        at = corner[normals.query(directions)[1]]
        height: NDArray[np.float64] = np.einsum("ij,ij->i", vertices[at], directions)
        climbing = np.arange(len(directions))
        while len(climbing):
            around = neighbours[at[climbing]]
            heights = np.einsum("ikj,ij->ik", vertices[around], directions[climbing])
            best = heights.argmax(axis=1)
            rows = np.arange(len(climbing))
            higher = heights[rows, best] > height[climbing]
            climbing, rows, best = climbing[higher], rows[higher], best[higher]
            at[climbing], height[climbing] = around[rows, best], heights[rows, best]
        return height

    @cached_property
    def _polytope(self) -> tuple[Points, NDArray[np.int64], cKDTree, NDArray[np.int64]] | None:
        """Vertices of the hull, a row of neighbours for each, its facets' normals, and a corner of each facet."""
        try:
            hull = ConvexHull(self._points)
        except QhullError:
            return None
        corners = np.sort(hull.vertices)
        vertices, triangles, count = self._points[corners], np.searchsorted(corners, hull.simplices), len(corners)
        ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        ends = np.concatenate([ends, ends[:, ::-1]])
        graph = coo_array((np.ones(len(ends), dtype=bool), (ends[:, 0], ends[:, 1])), shape=(count, count)).tocsr()
        degree = np.diff(graph.indptr)
        neighbours = np.repeat(np.arange(count)[:, None], degree.max(), axis=1)  # itself where there are no more
        neighbours[np.arange(degree.max()) < degree[:, None]] = graph.indices
        return vertices, neighbours, cKDTree(hull.equations[:, :3]), triangles[:, 0].copy()


def _farthest(points: Points, directions: Points) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The index of the point that lies farthest in each direction, and how far it lies."""
    index, height = np.zeros(len(directions), dtype=np.int64), np.zeros(len(directions))
    block = max(1, BLOCK // len(points))
    for start in range(0, len(directions), block):
        heights = directions[start : start + block] @ points.T
        index[start : start + block] = best = heights.argmax(axis=1)
        height[start : start + block] = heights[np.arange(len(best)), best]
    return index, height


def _spread(count: int) -> Points:
    """Unit vectors spread over the sphere along a spiral (Saff and Kuijlaars, 1997), shape (count, 3)."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), z])
