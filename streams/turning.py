"""How far an object turns between the pads when it is lifted.

Pads are flat: what they pinch on slanted faces turns until it lies flat between them, and what hangs beside them sags.
The object turns as long as the work of the closing fingers and its weight gain more than friction takes. It is looked
at turning about the line across the pads and about the approach axis; about the closing axis the whole face of a pad
resists.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.antipodal import half_spaces
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Gripper, Pose
from tamp.task.robot import PAD_FRICTION

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP = 0.04  # between the angles looked at [rad]
FARTHEST = 0.7  # [rad]
RAYS = (5, 13)  # across and along a pad, at which the object is felt
BESIDE = 0.01  # parts that are farther than this from where the pads are play no role [m]
TRUSTED = 0.5  # share of the friction that is counted on: lifting shakes, and pads do not touch everywhere
GRAVITY = 9.81  # [m/s^2]


def turning(workspace: Workspace, obj: str, grasp: Grasp, pose: Pose) -> float:
    """The angle that an object turns by, held by a grasp and lifted from a pose [rad]; 0 where it keeps still."""
    item, geometry = workspace.task.object(obj), workspace.world.geometries[obj]
    gripper = workspace.world.robot.spec.gripper
    weight = item.mass * GRAVITY
    force = gripper.holding_force(weight, item.friction)
    R, t = _in_pads(gripper, grasp)
    near = [part for part in geometry.parts if _is_near(part.vertices @ R.T + t, gripper, grasp.width)]
    faces = [(A @ R.T, b + A @ R.T @ t) for A, b in map(half_spaces, near)]
    up, center = R @ pose.matrix[2, :3], R @ geometry.center_of_mass + t

    def energy(turn: Array) -> float:
        thickness = _thickness([(A @ turn.T, b) for A, b in faces], gripper, grasp.width)
        return force * thickness + weight * float(up @ turn @ center)

    resisted = TRUSTED * PAD_FRICTION * item.friction * force * grasp.width * STEP
    axes = (_about_side, _about_approach)
    return max(_slide(energy, about, step, resisted) for about in axes for step in (STEP, -STEP))


def _slide(energy: Callable[[Array], float], about: Callable[[float], Array], step: float, resisted: float) -> float:
    """How far the angle goes in steps that set free more energy than they take, alone or with the next one [rad]."""
    reached, least = 0, energy(about(0.0))
    for count in range(1, round(FARTHEST / abs(step)) + 1):
        spent = energy(about(count * step)) + count * resisted
        if spent < least:
            reached, least = count, spent
        elif count > reached + 1:
            break
    return reached * abs(step)


def _in_pads(gripper: Gripper, grasp: Grasp) -> tuple[Array, Array]:
    """Rotation and translation from the object's frame to one whose axes are the pads' side, closing and approach."""
    closing = np.array(gripper.axis)
    axes = np.stack([np.cross(closing, [0.0, 0.0, 1.0]), closing, [0.0, 0.0, 1.0]])
    T = grasp.T_object_tool.inverse().matrix
    return axes @ T[:3, :3], axes @ T[:3, 3]


def _is_near(points: Array, gripper: Gripper, width: float) -> bool:
    half = np.array([gripper.pad[1], width, gripper.pad[2]]) / 2 + BESIDE
    return bool((points.min(axis=0) < half).all() and (points.max(axis=0) > -half).all())


def _about_side(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_approach(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _thickness(faces: list[tuple[Array, Array]], gripper: Gripper, width: float) -> float:
    """How far apart the pads stand with what lies between them, parts given as {x : A x <= b} [m]."""
    across, along = (np.linspace(-side / 2, side / 2, count) for side, count in zip(gripper.pad[1:], RAYS, strict=True))
    origins = np.array([(x, 0.0, z) for x in across for z in along])
    low, high = math.inf, -math.inf
    for A, b in faces:
        speed, gap = A[:, 1:2], b[:, None] - A @ origins.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / speed
        enter = np.where(speed < -1e-9, t, -np.inf).max(axis=0)
        leave = np.where(speed > 1e-9, t, np.inf).min(axis=0)
        beside = ((np.abs(speed) <= 1e-9) & (gap < 0)).any(axis=0)
        met = ~beside & (enter < leave) & (np.abs(enter + leave) < width + 0.002)
        low, high = min(low, *enter[met], math.inf), max(high, *leave[met], -math.inf)
    return max(0.0, high - low)
