"""How far from each joint's axis the arm can have a point: what bounds the motion of its fastest point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.chain import chain
from tamp.world.robot_model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reach:
    """Upper bounds over all configurations, one for each joint of the arm.

    Attributes:
        body: from the joint to the farthest point of the links beyond it, shape (dof,) [m].
        tool_joint: from the joint to the one that carries the tool, shape (dof,) [m].
        slides: whether the joint is prismatic, shape (dof,).
    """

    body: Vector
    tool_joint: Vector
    slides: NDArray[np.bool_]

    def levers(self, held: float) -> Vector:
        """Metres that no point moves beyond for a radian (or a metre) of each joint, shape (dof,).

        Args:
            held: from the joint that carries the tool to the farthest point of what is held [m]; 0 for nothing.
        """
        return np.where(self.slides, 1.0, np.maximum(self.body, self.tool_joint + held))


@cache
def reach_of(robot: RobotModel) -> Reach:
    """The reach of a robot's joints: the lengths of its links added up, as if it could stretch them into a line."""
    arm, joints = chain(robot), [robot.model.getJointId(name) for name in robot.spec.joints]
    travel = np.where(arm.slides, np.maximum(np.abs(robot.lower), np.abs(robot.upper)), 0.0)
    links = np.linalg.norm(arm.offset, axis=1) + travel
    radius = np.array([_radius(robot, joint) for joint in joints])
    count = robot.dof
    between = np.array([[links[i + 1 : k + 1].sum() for k in range(count)] for i in range(count)])
    body = np.array([(between[i, i:] + radius[i:]).max() for i in range(count)])
    return Reach(body, between[:, -1], arm.slides)


def _radius(robot: RobotModel, joint: int) -> float:
    """From a joint to the farthest point of the bodies it carries, the fingers that slide on it included [m]."""
    farthest = 0.0
    for body in robot.bodies:
        points = np.linalg.norm(body.hull.vertices, axis=1).max()
        if body.joint == joint:
            farthest = max(farthest, float(points))
        elif body.name in robot.spec.gripper.fingers and robot.model.parents[body.joint] == joint:
            offset = np.linalg.norm(robot.model.jointPlacements[body.joint].translation)
            farthest = max(farthest, float(points + offset + robot.spec.gripper.stroke / 2))
    return farthest
