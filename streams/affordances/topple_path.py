"""How an object that no hand can grasp as it stands is pushed over one of its edges, and on which face it then lies.

A push near its top turns it about the edge ahead before it slides, as long as the friction under it bears what the
push has to be: the weight times its lever about that edge, over the height of the push (Lynch, Toppling manipulation,
IEEE International Conference on Robotics and Automation 1999).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.graspable import graspable
from tamp.streams.affordances.slide_path import STEADY, slidable, squat
from tamp.streams.affordances.stable_poses import base, resting, stays
from tamp.streams.affordances.tilts import ROLL, base_normals, rolls, too_wide
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.task.model import TABLE_FRICTION
from tamp.world.transforms import rotation, turned_about

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry.object_geometry import Geometry

    Array = NDArray[np.float64]

BEYOND = 0.006  # the edge that it turns about, its centre of mass is pushed [m]
FIRM = 0.85  # share of the friction under an object that a push may call on
FARTHEST = np.radians(120.0)  # that an object turns until it lies
LANDED = np.radians(4.0)  # from lying on a face
BELOW_TOP = (0.012, 0.02, 0.035)  # of the object the hand pushes [m]


@dataclass(frozen=True, eq=False)
class Topple:
    """A way for an object over one of its edges.

    Attributes:
        ahead: level unit vector in which it is pushed, (3,).
        heights: above the table at which it tips before it slides, the best first [m].
        share: of its weight that this takes, at most.
        pushed: its poses while it is pushed, the first at rest, the last one past its balance.
        fall: those after that, from the last one on to `end`.
        end: where it lies at last.
    """

    ahead: Array
    heights: Array
    share: float
    pushed: tuple[Pose, ...]
    fall: tuple[Pose, ...]
    end: Placement


def topplable(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether an object can be taken from a placement only after it was pushed over.

    That is so where it stands on the table, is wider than the hand opens and no hand that would pinch it has room, but
    one edge of it lets it be toppled.
    """

    def found() -> bool:
        tall = placement.on == (TABLE,) and too_wide(workspace, obj, placement) and not squat(workspace, obj, placement)
        topples_over = tall and bool(topples(workspace, obj, placement))
        return topples_over and not graspable(workspace, obj, placement)

    return workspace.cache.value(("topplable", obj, placement), found)


def to_be_pushed(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether an object can be taken from a placement only after it was slid or toppled."""
    return slidable(workspace, obj, placement) or topplable(workspace, obj, placement)


def topples(workspace: Workspace, obj: str, placement: Placement) -> list[Topple]:
    """Ways over the edges of an object's base, those first after which it does not roll on, and then the nearest."""
    geometry = workspace.world.geometries[obj]
    base_xy = np.array(workspace.world.robot.spec.T_world_base.xyz[:2])

    def rank(topple: Topple) -> tuple[bool, float]:
        away = float(np.linalg.norm(topple.end.pose.xyz[:2] - base_xy))
        return not stays(geometry, topple.end.pose.matrix[:3, :3]), away

    return workspace.cache.value(
        ("topples", obj, placement), lambda: sorted(_topples(workspace, obj, placement), key=rank)
    )


def _topples(workspace: Workspace, obj: str, placement: Placement) -> Iterator[Topple]:
    geometry, T = workspace.world.geometries[obj], placement.pose.matrix
    world = geometry.hull.vertices @ T[:3, :3].T + T[:3, 3]
    center = T[:3, :3] @ geometry.center_of_mass + T[:3, 3]
    friction = FIRM * TABLE_FRICTION * workspace.task.object(obj).friction
    for outward in base_normals(base(world)):
        lever = float((base(world) @ outward).max() - center[:2] @ outward)
        above = world[:, 2].max() - np.array(BELOW_TOP)
        heights = above[(above - world[:, 2].min()) * friction > lever]
        pushed, fall = _turned_over(geometry, T, outward, resting(workspace, obj))
        if len(heights) and fall and _on_table(workspace, obj, fall[-1]):
            before, after = (tuple(map(Pose.from_matrix, part)) for part in (pushed, fall))
            share = lever / float(heights.min() - world[:, 2].min())
            yield Topple(np.append(outward, 0.0), heights, share, before, after, Placement(after[-1], (TABLE,)))


def _turned_over(geometry: Geometry, T: Array, outward: Array, faces: list[Array]) -> tuple[list[Array], list[Array]]:
    """Poses (4, 4) of a body that is pushed over its edge towards `outward`, and of its fall; none if it does not lie.

    `faces` are the orientations, shape (3, 3), in which it rests.
    """
    vertices, center = geometry.hull.vertices, geometry.center_of_mass
    pushed = [T]
    fall: list[Array] = []
    for rolled, touching in islice(rolls(vertices, T, outward), round(FARTHEST / ROLL)):
        if fall:
            if (landed := _landed(vertices, rolled, faces)) is not None:
                return pushed, [*fall, landed]
            fall.append(rolled)
        else:
            pushed.append(rolled)
            if (rolled[:3, :3] @ center + rolled[:3, 3])[:2] @ outward > touching.max() + BEYOND:
                fall.append(rolled)
    return pushed, []


def _landed(vertices: Array, T: Array, faces: list[Array]) -> Array | None:
    """The pose, shape (4, 4), of a body that nearly lies on one of its faces when it does; None if it does not."""
    world = vertices @ T[:3, :3].T + T[:3, 3]
    lowest = world[np.argmin(world[:, 2])]
    for R in faces:
        axis = np.cross(T[:3, :3] @ -R[2], [0.0, 0.0, -1.0])
        angle = float(np.arctan2(np.linalg.norm(axis), (T[:3, :3] @ R[2])[2]))
        if angle < LANDED:
            lying = turned_about(lowest, rotation(axis / max(float(np.linalg.norm(axis)), 1e-12), angle), T)
            lying[2, 3] += lowest[2] - (vertices @ lying[2, :3] + lying[2, 3]).min()
            return lying
    return None


def _on_table(workspace: Workspace, obj: str, T: Array) -> bool:
    """Whether all of what an object lies on is on the table."""
    table = workspace.task.table
    points = base(workspace.points(obj) @ T[:3, :3].T + T[:3, 3])
    return bool((np.abs(points - table.center) < np.array(table.size) / 2 - STEADY).all())
