"""Where the pads are that a robot's file tells of, against its fingers' hulls; all in the tool frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.task import Gripper
from tamp.world.robot.hand import hand_poses
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def finger_points(robot: RobotModel, opening: float) -> list[Array]:
    """The corners of each finger's hulls at an opening [m]; shape (n, 3) each [m]."""
    poses = hand_poses(robot, opening)
    bodies = [(robot.bodies[index], T) for index, T in zip(robot.hand, poses, strict=True)]
    return [
        np.concatenate([b.hull.vertices @ T[:3, :3].T + T[:3, 3] for b, T in bodies if b.name == finger])
        for finger in robot.spec.gripper.fingers
    ]


def inner(gripper: Gripper, points: Array) -> float:
    """Where the face of a finger, (n, 3), that looks inwards is along the closing axis [m]."""
    along = points @ np.array(gripper.axis)
    return float(along.min() if along.mean() > 0 else along.max())


def beyond(gripper: Gripper, points: Array) -> float:
    """How far a pad, centred on the tool's axis, reaches beyond a finger's hull (n, 3) across the closing axis [m]."""
    along = points @ np.cross(gripper.axis, (0.0, 0.0, 1.0))
    return float(gripper.pad[1] / 2 - min(-along.min(), along.max()))


def past_ends(gripper: Gripper, points: Array, depth: float) -> tuple[float, float]:
    """How far a pad whose middle is at a place along the approach [m] reaches beyond a finger's hull (n, 3).

    Returns:
        Beyond the fingertip, and beyond the finger's other end [m]; negative where it ends before.
    """
    half, along = gripper.pad[2] / 2, points[:, 2]
    return float(depth + half - along.max()), float(along.min() - (depth - half))
