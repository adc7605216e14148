"""The shape of the hand alone, seen from its tool frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from tamp.world.robot_model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray


def hand_points(robot: RobotModel, opening: float) -> tuple[NDArray[np.float64], ...]:
    """Vertices of the convex hulls of hand and fingers in the tool frame, shapes (n, 3) [m].

    Args:
        robot: the robot.
        opening: distance between the finger pads [m].
    """
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full(robot.home, opening))
    T_tool_world = (data.oMi[robot.tool_joint] * pin.SE3(robot.T_joint_tool)).inverse()
    hulls = []
    for body in (robot.bodies[index] for index in robot.hand):
        T = (T_tool_world * data.oMi[body.joint]).homogeneous
        hulls.append(body.hull.vertices @ T[:3, :3].T + T[:3, 3])
    return tuple(hulls)
