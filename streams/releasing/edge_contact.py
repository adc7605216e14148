"""The edge over which something falls: whether it is held up on a rim, or taken along by a finger."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.stable_poses import TOUCHING
from tamp.streams.hand.clearance import opening_for
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.task.model import TABLE_FRICTION
from tamp.task.robot import PAD_FRICTION
from tamp.world.scene import Scene
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def friction_beneath(workspace: Workspace, obj: str, placement: Placement) -> float:
    """The coefficient between an object and the smoothest of what it lies on."""
    below = (TABLE_FRICTION if name == TABLE else workspace.task.object(name).friction for name in placement.on)
    return workspace.task.object(obj).friction * min(below)


NEAR = 0.004  # what is nearer than this touches [m]
UPWARD = 0.2  # a contact carries where the vertical share of its normal is over this
SLIDES = 0.004  # farthest that an object may have to slide where it is carried [m]
LOWEST = 0.002  # what carries it so little above its lowest point carries it at the edge that it rolls over [m]


def held_up(workspace: Workspace, obj: str, fall: tuple[Pose, ...], below: Mapping[str, Placement]) -> bool:
    """Whether an object that is let go on some others would have to slide far wherever those carry it.

    That is so on a rim above its lowest edge, not on that edge itself.

    Args:
        workspace: the shapes.
        obj: the object.
        fall: its poses (world frame), the tilted one first, the last one at rest.
        below: the others, of which it has to stay on one; what it leans on besides, it may leave.
    """
    before, after = fall[0].matrix, fall[-1].matrix
    T = after @ np.linalg.inv(before)
    center = _aside(before[:3, :3] @ workspace.world.geometries[obj].center_of_mass + before[:3, 3], T)
    bottom, slides = float((workspace.points(obj) @ before[2, :3]).min() + before[2, 3]), []
    for name, place in below.items():
        points, normals = workspace.world.contacts(obj, before, name, place.pose.matrix, NEAR)
        carrying = points[normals[:, 2] >= UPWARD]
        if (carrying[:, 2] < bottom + LOWEST).any():
            return False
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


BENEATH = 0.6  # a finger is below the object where its upward side and the closing axis are this near (cosine)


def dragged(workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, tilted: Pose) -> bool:
    """Whether an object let go on one edge would go with the hand that draws back along its axis.

    Args:
        workspace: where the object is.
        obj: the object.
        placement: where it comes to lie.
        grasp: how it is held.
        tilted: T_world_object where it is let go; its lowest edge is on what it shall lie on.
    """
    beneath = _finger_beneath(workspace, placement, grasp, tilted)
    if beneath is None:
        return False
    up, rising, T_pads = beneath
    center, finger, height = _levers(workspace, obj, tilted, T_pads, rising)
    if center <= 0.0 or finger <= 0.0:
        return False
    sunk = (opening_for(workspace.world.robot.spec.gripper, grasp) - grasp.width) / 2
    angle = np.arccos(up[2]) - sunk / np.hypot(finger, height)
    if angle <= 0.0:
        return False  # it lies flat before it comes down on the finger
    if finger <= center:
        return True  # it tips over the finger, which carries all of it
    normal, back = np.append(-np.sin(angle) * rising, np.cos(angle)), -T_pads[:3, 2]
    along = back - normal * (normal @ back)
    pull = workspace.task.object(obj).friction * PAD_FRICTION
    # The finger's force on the object, as a share of its weight.
    pressed = center / finger * np.cos(angle)
    force = pressed * (normal + pull * along / np.linalg.norm(along))
    held = friction_beneath(workspace, obj, placement) * (1.0 - force[2])
    return bool(force[:2] @ along[:2] > held * np.linalg.norm(along[:2]))


BESIDE = 0.5  # a finger as far beside the plane of a fall, as a share of how far it is beyond the centre of mass


def turned_off(workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, tilted: Pose) -> bool:
    """Whether an object let go on one edge turns sideways off the finger beneath it, which is beside its way down.

    On the table it lies flat in the end whichever way it turns; over the table's edge it goes down there.

    Args:
        workspace: where the object is.
        obj: the object.
        placement: where it comes to lie.
        grasp: how it is held.
        tilted: T_world_object where it is let go; its lowest edge is on what it shall lie on.
    """
    beneath = _finger_beneath(workspace, placement, grasp, tilted)
    if beneath is None:
        return False
    _, rising, T_pads = beneath
    center = tilted.matrix[:3, :3] @ workspace.world.geometries[obj].center_of_mass + tilted.matrix[:3, 3]
    beyond, beside = (float((T_pads[:3, 3] - center)[:2] @ way) for way in (rising, np.array([-rising[1], rising[0]])))
    return abs(beside) > BESIDE * beyond


def _finger_beneath(
    workspace: Workspace, placement: Placement, grasp: Grasp, tilted: Pose
) -> tuple[Array, Array, Array] | None:
    """How an object lies on a finger where it is let go, or None where no finger is beneath it, or it lies flat.

    Returns:
        Its upward side (3,), where it rises from its lowest edge (2,), and T_world_pads, shape (4, 4).
    """
    robot, T_tool = workspace.world.robot, tilted.matrix @ grasp.T_object_tool.matrix
    up = tilted.matrix[:3, :3] @ placement.pose.matrix[2, :3]
    level = float(np.hypot(*up[:2]))
    if level < 1e-9 or abs(up @ T_tool[:3, :3] @ np.array(robot.spec.gripper.axis)) < BENEATH:
        return None
    return up, -up[:2] / level, moved(T_tool, float(robot.linkage.depth(grasp.width)) * T_tool[:3, 2])


CARRYING = 0.3  # a finger carries where the closing axis points so far up or down (cosine); else they are beside
GRAZED = 1  # poses of a fall at which a finger may be met: it is passed, and stops nothing


def hooked(workspace: Workspace, obj: str, grasp: Grasp, fall: tuple[Pose, ...]) -> bool:
    """Whether an object, let go on one edge, stays hanging on a finger and goes with it.

    It falls sooner than the hand is gone. A finger beneath the side that it shall lie on keeps it up too, but leaves
    along it (see `dragged`); one that is in a bowl, say, which turns over it, does not.

    Args:
        workspace: where the object is.
        obj: the object.
        grasp: how it was held.
        fall: its poses (world frame), from where it is let go to where it lies.
    """
    gripper, T_tool = workspace.world.robot.spec.gripper, fall[0].matrix @ grasp.T_object_tool.matrix
    closing, up = T_tool[:3, :3] @ np.array(gripper.axis), fall[0].matrix[:3, :3] @ fall[-1].matrix[2, :3]
    if abs(closing[2]) < CARRYING or abs(up @ closing) >= BENEATH:
        return False
    hand = workspace.world.free_hand(Scene(poses={obj: np.eye(4)}), 0.0, ignore={TABLE})
    seen = np.array([np.linalg.inv(pose.matrix) @ T_tool for pose in fall])  # from the object
    return bool(hand.hits(seen, np.full(len(seen), opening_for(gripper, grasp))).sum() > GRAZED)


def _levers(workspace: Workspace, obj: str, tilted: Pose, T_pads: Array, rising: Array) -> tuple[float, float, float]:
    """How far the centre of mass and the pads are from the edge towards where the object rises (2,), and how high."""
    T = tilted.matrix
    points = workspace.points(obj) @ T[:3, :3].T + T[:3, 3]
    bottom = points[:, 2].min()
    edge = (points[points[:, 2] < bottom + TOUCHING, :2] @ rising).max()
    center = T[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T[:3, 3]
    return float(center[:2] @ rising - edge), float(T_pads[:2, 3] @ rising - edge), float(T_pads[2, 3] - bottom)
