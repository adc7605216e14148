"""How high must a body's centre of mass rise before it tips over an edge of what it stands on?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import inverse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.geometry.solids import Solid
    from tamp.checking.scene import Scene, State

    Array = NDArray[np.float64]

TURNS = np.radians(np.arange(0.0, 91.0))
"""How far on a body has turned when it is asked whether it still rises [rad]."""
BEFORE = 0.0015
"""What catches it does so while its centre of mass is at least this far on the near side of the edge [m]."""
CAUGHT = 3e-4
"""And while that part of it would be at least so much lower than the edge [m]."""
UNDER = np.arange(0.001, 0.0041, 0.001)
"""What comes down on a body comes down where that is solid, so far below the edge: it stands across such gaps [m]."""


def rise_to_tip(scene: Scene, state: State, name: str, under: str, edge: Array, way: Array) -> float:
    """How high the centre of mass of an object is lifted before the object tips over an edge for good [m].

    What else of it comes down on the same body clearly before it is in balance on the edge, as the rim of a plate on a
    narrow foot, carries it from there on: it rolls on over its hull as long as that lifts it.

    Args:
        scene: the bodies.
        state: where all of them are.
        name: the object.
        under: what it stands on at the edge.
        edge: a point of that, shape (3,) [m].
        way: level unit vector in which the object tips, shape (3,).
    """
    T, T_under = state.poses[name], state.standing(scene)[under]
    center = scene.center_of_mass(name, T)
    inside, height = max(float((edge - center) @ way), 0.0), float(center[2] - edge[2])
    radius = float(np.hypot(inside, height))
    clearly = float(np.arctan2(inside, height) - np.arcsin(min(BEFORE / radius, 1.0)))
    corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    solid, T_under_world = scene.solids[under], inverse(T_under)
    below = (np.column_stack([corners[:, :2], np.full(len(corners), edge[2] - depth)]) for depth in UNDER)
    arms = corners[np.any([_within(solid, T_under_world, points) for points in below], axis=0)] - center
    if clearly <= 0.0 or not len(arms):
        return radius - height
    turns = clearly + TURNS
    heights = (np.outer(np.sin(turns), arms @ way) - np.outer(np.cos(turns), arms[:, 2])).max(axis=1)
    if heights[0] < inside * np.sin(clearly) + height * np.cos(clearly) + CAUGHT:
        return radius - height
    sinks = np.flatnonzero(np.diff(heights) <= 0.0)
    return float(heights[sinks[0]] if len(sinks) else heights[-1]) - height


def _within(solid: Solid, T: Array, points: Array) -> NDArray[np.bool_]:
    """Which points, shape (n, 3), are inside of a solid; T, shape (4, 4), takes them into its frame."""
    local = points @ T[:3, :3].T + T[:3, 3]
    inside = np.zeros(len(points), bool)
    for piece in solid.pieces:
        normals, offsets = piece.planes
        inside |= (local @ normals.T <= offsets).all(axis=1)
    return inside
