"""Skidding: the edge over which something falls flat slides away beneath it, farther the smoother what it is set on.

The body is let go at rest and falls in a plane, its edge pressed to the support, which holds it by Coulomb friction as
far as that goes. Where it skids is known beforehand, so it is let go as far from there as it skids.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.footing import TOUCHING
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.task.model import TABLE_FRICTION

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
    key = ("skid", round(lever[0], 4), round(lever[1], 4), round(gyration, 6), round(angle, 3), friction)
    if key not in workspace.memory:
        workspace.memory[key] = float(np.clip(skid(lever, gyration, angle, friction), -FARTHEST, FARTHEST))
    shift = workspace.memory[key] * rising
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
