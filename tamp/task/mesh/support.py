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
BESIDE = 1 << 10
"""Climbs at a time."""


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
        blocks = (directions[start : start + BESIDE] for start in range(0, len(directions), BESIDE))
        return np.concatenate([np.zeros(0), *(self._polytope.climbed(block) for block in blocks)])

    @cached_property
    def _polytope(self) -> _Polytope | None:
        try:
            return _Polytope(ConvexHull(self._points))
        except QhullError:
            return None


class _Polytope:
    """The vertices of a convex hull and the edges between them; a vertex may have very many, as the tip of a cone."""

    def __init__(self, hull: ConvexHull) -> None:
        corners = np.sort(hull.vertices)
        triangles, count = np.searchsorted(corners, hull.simplices), len(corners)
        ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        ends = np.concatenate([ends, ends[:, ::-1]])
        graph = coo_array((np.ones(len(ends), dtype=bool), (ends[:, 0], ends[:, 1])), shape=(count, count)).tocsr()
        self._vertices, self._neighbours, self._first = hull.points[corners], graph.indices, graph.indptr
        self._normals = cKDTree(hull.equations[:, :3])
        fewest = np.diff(graph.indptr)[triangles].argmin(axis=1)
        self._corner = triangles[np.arange(len(triangles)), fewest]  # of each facet: where a climb has least to look at

    def climbed(self, directions: Points) -> NDArray[np.float64]:
        """How far the polytope reaches in directions, shape (m, 3) -> (m,) [m]."""
        at = self._corner[self._normals.query(directions)[1]]
        height: NDArray[np.float64] = np.einsum("ij,ij->i", self._vertices[at], directions)
        climbing = np.arange(len(directions))
        while len(climbing):
            first, count = self._first[at[climbing]], np.diff(self._first)[at[climbing]]
            begin = np.cumsum(count) - count
            owner = np.repeat(np.arange(len(climbing)), count)
            around = self._neighbours[np.arange(len(owner)) + np.repeat(first - begin, count)]
            heights = np.einsum("ij,ij->i", self._vertices[around], directions[climbing][owner])
            best = np.maximum.reduceat(heights, begin)
            rows, where = np.unique(owner[heights == best[owner]], return_index=True)
            there = around[heights == best[owner]][where]
            higher = best > height[climbing]
            climbing, there, best = climbing[rows][higher], there[higher], best[higher]
            at[climbing], height[climbing] = there, best
        return height


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
