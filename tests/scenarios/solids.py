"""How deep two objects of a scene lie in each other, by the separating axes of their convex parts."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from tamp.task import Pose, Shape
from tamp.task.mesh.parts import parts

Corners = NDArray[np.float64]


def placed(shape: Shape, pose: Pose) -> list[Corners]:
    """The corners of the shape's convex parts in the world frame."""
    T = pose.matrix
    return [part.vertices @ T[:3, :3].T + T[:3, 3] for part in parts(shape)]


def overlap(first: list[Corners], second: list[Corners]) -> float:
    """The depth to which two bodies of convex parts lie in each other; 0 where they are apart [m]."""
    return max((_depth(a, b) for a, b in product(first, second) if _boxes_meet(a, b)), default=0.0)


def bottom(body: list[Corners]) -> float:
    """Height of the lowest corner [m]."""
    return min(float(corners[:, 2].min()) for corners in body)


def _boxes_meet(a: Corners, b: Corners) -> bool:
    return bool((a.min(axis=0) < b.max(axis=0)).all() and (b.min(axis=0) < a.max(axis=0)).all())


def _depth(a: Corners, b: Corners) -> float:
    from scipy.spatial import ConvexHull

    hulls = [ConvexHull(a), ConvexHull(b)]
    normals = [np.unique(hull.equations[:, :3].round(6), axis=0) for hull in hulls]
    edges = [_edges(hull) for hull in hulls]
    crossed = np.cross(edges[0][:, None], edges[1][None]).reshape(-1, 3)
    axes = np.vstack([*normals, crossed[np.linalg.norm(crossed, axis=1) > 1e-3]])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    p, q = a @ axes.T, b @ axes.T
    gaps = np.maximum(p.min(axis=0) - q.max(axis=0), q.min(axis=0) - p.max(axis=0))
    return max(0.0, float(-gaps.max()))


def _edges(hull) -> NDArray[np.float64]:
    """Directions of the hull's edges, those inside a flat face left in; up to sign."""
    corners = hull.points[hull.simplices]
    directions = np.vstack([corners[:, i] - corners[:, i - 1] for i in range(3)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    directions *= np.where(directions @ np.array([1.0, 1e-3, 1e-6]) < 0, -1.0, 1.0)[:, None]
    return np.unique(directions.round(6), axis=0)
