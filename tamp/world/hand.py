"""The shape of the hand alone, seen from its tool frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from tamp.world.robot_model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]


def hand_poses(robot: RobotModel, opening: float) -> tuple[Matrix, ...]:
    """Poses of hand and fingers in the tool frame, in the order of `robot.hand`, shapes (4, 4).

    Args:
        robot: the robot.
        opening: distance between the finger pads [m].
    """
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full(robot.home, opening))
    T_tool_world = (data.oMi[robot.tool_joint] * pin.SE3(robot.T_joint_tool)).inverse()
    return tuple((T_tool_world * data.oMi[robot.bodies[index].joint]).homogeneous for index in robot.hand)


def hand_points(robot: RobotModel, opening: float) -> tuple[Matrix, ...]:
    """Vertices of the convex hulls of hand and fingers in the tool frame, shapes (n, 3) [m]; `opening` as above."""
    poses = zip((robot.bodies[index] for index in robot.hand), hand_poses(robot, opening), strict=True)
    return tuple(body.hull.vertices @ T[:3, :3].T + T[:3, 3] for body, T in poses)
