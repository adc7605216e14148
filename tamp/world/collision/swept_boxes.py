"""Boxes that the arm stays within along a path: they tell at once most of the things that it cannot meet there."""

from __future__ import annotations

import itertools
import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Boxes = tuple[Array, Array]
    """Lower and upper corners, shapes (n, 3) [m]."""


def swept_boxes(
    robot: RobotModel, path: Array, opening: float, held: Array | None = None, resolution: float = 0.05
) -> Boxes:
    """Boxes along the world's axes around each moving link, and around what is held, wherever they are on a path.

    Args:
        robot: the robot.
        path: straight between its points, shape (n, dof) [rad].
        opening: distance between the finger pads [m].
        held: points of what the tool holds, in the tool frame, shape (m, 3) [m].
        resolution: the states looked at are at most so far apart [rad].

    Returns:
        Lower and upper corners, shapes (bodies, 3) [m].
    """
    joints, center, half = _link_boxes(robot)
    if held is not None:
        points = held @ robot.T_joint_tool[:3, :3].T + robot.T_joint_tool[:3, 3]
        low, high = points.min(axis=0), points.max(axis=0)
        joints = np.append(joints, robot.tool_joint)
        center, half = np.vstack([center, (low + high) / 2]), np.vstack([half, (high - low) / 2])
    T = robot.joint_poses(_states(path, resolution), opening)[:, joints]
    middle = np.einsum("sbij,bj->sbi", T[..., :3, :3], center) + T[..., :3, 3]
    reach = np.einsum("sbij,bj->sbi", np.abs(T[..., :3, :3]), half)
    return (middle - reach).min(axis=0), (middle + reach).max(axis=0)


@cache
def _link_boxes(robot: RobotModel) -> tuple[NDArray[np.int64], Array, Array]:
    """Joint (n,), centre (n, 3) and half size (n, 3) of each moving link's box in its joint's frame."""
    moving = [body for body in robot.bodies if body.joint > 0]
    low = np.array([body.hull.vertices.min(axis=0) for body in moving])
    high = np.array([body.hull.vertices.max(axis=0) for body in moving])
    return np.array([body.joint for body in moving]), (low + high) / 2, (high - low) / 2


def _states(path: Array, resolution: float) -> Array:
    """The path's points and points between them, none farther apart than the resolution, shape (s, dof)."""
    states = [path[:1]]
    for q0, q1 in itertools.pairwise(path):
        steps = max(1, math.ceil(float(np.linalg.norm(q1 - q0)) / resolution))
        states.append(q0 + np.arange(1, steps + 1)[:, None] / steps * (q1 - q0))
    return np.concatenate(states)
