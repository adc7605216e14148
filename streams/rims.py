"""Rims: what carries a tilted object besides the edge it is set on, it would have to slide off as it falls.

A body that falls over its edge turns about that: where friction holds the edge it stays, on ice the centre of mass
falls straight down. All else by which the same body below carries it, such as the rim of a box that it leans on, has to
stay as well, or else it is held up there and falls in some other way.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

NEAR = 0.004  # what is nearer than this touches [m]
UPWARD = 0.2  # a contact carries where the vertical share of its normal is over this
SLIDES = 0.013  # farthest that an object may have to slide where it is carried [m]


def held_up(workspace: Workspace, obj: str, fall: tuple[Pose, ...], below: Mapping[str, Placement]) -> bool:
    """Whether an object that is let go on some others would have to slide far wherever those carry it.

    Args:
        workspace: the shapes.
        obj: the object.
        fall: its poses (world frame), the tilted one first, the last one at rest.
        below: the others, of which it has to stay on one; what it leans on besides, it may leave.
    """
    before, after = fall[0].matrix, fall[-1].matrix
    T = after @ np.linalg.inv(before)
    center = _aside(before[:3, :3] @ workspace.world.geometries[obj].center_of_mass + before[:3, 3], T)
    slides = []
    for name, place in below.items():
        points, normals = workspace.world.contacts(obj, before, name, place.pose.matrix, NEAR)
        carrying = points[normals[:, 2] >= UPWARD]
        slides += [max(_distance(_aside(point, T), center) for point in carrying)] if len(carrying) else []
    return min(slides, default=0.0) > SLIDES


def _aside(point: Array, T: Array) -> Array:
    """How far aside T, shape (4, 4), takes a point (3,), shape (2,) [m]."""
    way: Array = T[:2, :3] @ point + T[:2, 3] - point[:2]
    return way


def _distance(a: Array, b: Array) -> float:
    """Distance of the origin from the segment between two points of the plane [m]."""
    along = b - a
    share = np.clip(-(a @ along) / max(float(along @ along), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(a + share * along))
