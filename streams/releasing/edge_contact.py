"""The edge over which something falls: whether it slides away, meets a rim, or is taken along by a finger."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.stable_poses import TOUCHING
from tamp.streams.affordances.support import near_upward
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

GRAVITY = 9.81  # [m/s^2]
STEP = 1e-3  # of the integration [s]
FARTHEST = 0.03  # that is aimed for: whatever would skid farther falls too far to say where it lands [m]
EVEN = 0.008  # the edge is part of the base: no higher than this above the lowest of it [m]
LONGEST = 1.0  # that a body may take to fall [s]


def friction_beneath(workspace: Workspace, obj: str, placement: Placement) -> float:
    """The coefficient between an object and the smoothest of what it lies on."""
    below = (TABLE_FRICTION if name == TABLE else workspace.task.object(name).friction for name in placement.on)
    return workspace.task.object(obj).friction * min(below)


def aimed(workspace: Workspace, obj: str, placement: Placement, fall: tuple[Pose, ...]) -> tuple[Pose, ...]:
    """A fall over an edge that stays where it is, shifted so that an object whose edge skids lands at the placement.

    The poses go from the tilted one to the placement's. What touches down with something else first, such as a plate
    with its foot, keeps its fall.
    """
    T, up = fall[0].matrix, fall[0].matrix[:3, :3] @ placement.pose.matrix[2, :3]
    rising = -up[:2] / np.linalg.norm(up[:2])
    points = workspace.points(obj)
    low = points @ T[2, :3] < (points @ T[2, :3]).min() + TOUCHING
    heights = points @ placement.pose.matrix[2, :3]
    if heights[low].max() > heights.min() + EVEN:
        return fall
    along = points @ T[:2, :3].T @ rising
    center = T[:3, :3] @ workspace.world.geometries[obj].center_of_mass
    lever = float(center[:2] @ rising - along[low].max()), float(center[2] - (points @ T[2, :3]).min())
    flat = points @ placement.pose.matrix[:2, :3].T @ rising
    gyration = float(np.ptp(flat) ** 2 + np.ptp(heights) ** 2) / 12.0
    friction, angle = friction_beneath(workspace, obj, placement), math.acos(min(1.0, float(up[2])))
    # Nearly the same fall skids nearly as far.
    lever, gyration, angle = (round(lever[0], 4), round(lever[1], 4)), round(gyration, 6), round(angle, 3)
    key = ("skid", lever, gyration, angle, friction)
    skidding = workspace.cache.value(key, lambda: skid(lever, gyration, angle, friction))
    shift = float(np.clip(skidding, -FARTHEST, FARTHEST)) * rising
    return tuple(
        _shifted(pose, share * shift) for pose, share in zip(fall, np.linspace(1.0, 0.0, len(fall)), strict=True)
    )


def skid(lever: tuple[float, float], gyration: float, angle: float, friction: float) -> float:
    """How far the edge of a body that falls flat slides, away from the side that is up [m].

    Args:
        lever: from the edge to the centre of mass, towards the side that is up and upwards [m].
        gyration: square of the radius of gyration about the centre of mass [m^2].
        angle: that it falls by [rad].
        friction: coefficient between the edge and what it is set on.
    """
    radius, heading = math.hypot(*lever), math.atan2(lever[1], lever[0])
    turned, spin, slid, speed = 0.0, 0.0, 0.0, 0.0  # towards the side that is up, and downwards
    for _ in range(round(LONGEST / STEP)):
        x, z = radius * math.cos(heading - turned), radius * math.sin(heading - turned)
        turning = GRAVITY * x / (gyration + radius**2)  # the edge held fast
        needed = (z * turning - x * spin**2) / (GRAVITY - x * turning - z * spin**2)
        pushing = 0.0
        if speed != 0.0 or abs(needed) > friction:
            share = -math.copysign(friction, speed) if speed != 0.0 else math.copysign(friction, needed)
            arm = x - share * z
            turning = arm * (GRAVITY - z * spin**2) / (gyration + arm * x)
            pressed = GRAVITY - x * turning - z * spin**2
            pushing = share * pressed - z * turning + x * spin**2
        spin += turning * STEP
        turned += spin * STEP
        before, speed = speed, speed + pushing * STEP
        speed = 0.0 if before * speed < 0.0 else speed
        slid += speed * STEP
        if turned >= angle:
            break
    return -slid


def _shifted(pose: Pose, shift: Array) -> Pose:
    x, y, z = pose.xyz
    return Pose((x + float(shift[0]), y + float(shift[1]), z), pose.quat)


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


ASIDE = 0.003  # the centre of mass is at least this far from either end of the edge where that is carried [m]
SAMPLES = 50  # points looked at along an edge


def unbalanced(workspace: Workspace, obj: str, fall: tuple[Pose, ...], below: Mapping[str, Placement]) -> bool:
    """Whether some others carry the edge of an object that is let go on one side of its centre of mass only.

    It would turn about the end of what is carried, and fall sideways.

    Args:
        workspace: the shapes.
        obj: the object.
        fall: its poses (world frame), the tilted one first, the last one at rest.
        below: what it is let go on.
    """
    T, geometry = fall[0].matrix, workspace.world.geometries[obj]
    up = T[:3, :3] @ fall[-1].matrix[2, :3]
    points = (geometry.hull.vertices - geometry.center_of_mass) @ T[:3, :3].T
    along = points[:, :2] @ np.array([-up[1], up[0]]) / float(np.hypot(*up[:2]))
    low = np.flatnonzero(points[:, 2] < points[:, 2].min() + NEAR)
    low = low[np.argsort(along[low], kind="stable")]
    where = np.linspace(along[low[0]], along[low[-1]], SAMPLES)
    edge = np.stack([np.interp(where, along[low], points[low, axis]) for axis in range(3)], axis=1)
    edge += T[:3, :3] @ geometry.center_of_mass + T[:3, 3]
    carried = where[np.any([near_upward(workspace, edge, name, place, NEAR) for name, place in below.items()], axis=0)]
    return len(carried) > 0 and not carried.min() + ASIDE < 0.0 < carried.max() - ASIDE


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
    gripper, T_tool = workspace.world.robot.spec.gripper, tilted.matrix @ grasp.T_object_tool.matrix
    up = tilted.matrix[:3, :3] @ placement.pose.matrix[2, :3]
    flat = float(np.hypot(*up[:2])) < 1e-9
    if flat or abs(up @ T_tool[:3, :3] @ np.array(gripper.axis)) < BENEATH:
        return False
    rising = -up[:2] / np.linalg.norm(up[:2])
    T_pads = moved(T_tool, float(workspace.world.robot.linkage.depth(grasp.width)) * T_tool[:3, 2])
    center, finger, height = _levers(workspace, obj, tilted, T_pads, rising)
    if not 0.0 < center < finger:
        return False
    sunk = (opening_for(gripper, grasp) - grasp.width) / 2
    angle = np.arccos(up[2]) - sunk / np.hypot(finger, height)
    normal, back = np.append(-np.sin(angle) * rising, np.cos(angle)), -T_tool[:3, 2]
    along = back - normal * (normal @ back)
    pull = workspace.task.object(obj).friction * PAD_FRICTION
    # The finger's force on the object, as a share of its weight.
    pressed = center / finger * np.cos(angle)
    force = pressed * (normal + pull * along / np.linalg.norm(along))
    held = friction_beneath(workspace, obj, placement) * (1.0 - force[2])
    return bool(force[:2] @ along[:2] > held * np.linalg.norm(along[:2]))


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
