"""How far the fastest point of the arm, and of what it holds, moves from one configuration to the next."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def travel(robot: RobotModel, configurations: Array, held: float) -> Array:
    """Metres that no point moves beyond between each two configurations, both of them seen as points of a chord.

    A point within r of a joint's origin moves no farther than the origin does and r times 2 sin(a / 2), a the angle
    that the joint's frame turns by; sqrt(1/2) times the Frobenius norm of the difference of two rotations is as much.

    Args:
        robot: the robot.
        configurations: shape (n, dof) [rad].
        held: from the joint that carries the tool to the farthest point of what is held [m]; 0 for nothing.

    Returns:
        Shape (n - 1,) [m].
    """
    radii = _radii(robot).copy()
    radii[-1] = max(radii[-1], held)
    steps = np.diff(chain(robot).frames(configurations), axis=1)
    moved = np.linalg.norm(steps[..., :3, 3], axis=-1)
    turned = np.linalg.norm(steps[..., :3, :3], axis=(-2, -1)) * np.sqrt(0.5)
    farthest: Array = (moved + radii[:, None] * turned).max(axis=0)
    return farthest


@cache
def _radii(robot: RobotModel) -> Array:
    """From each joint of the arm to the farthest point that it carries by itself, shape (dof,) [m]."""
    return np.array([_radius(robot, robot.model.getJointId(name)) for name in robot.spec.joints])


def _radius(robot: RobotModel, joint: int) -> float:
    """From a joint to the farthest point of the bodies it carries, the gripper's that move on it included [m]."""
    farthest = 0.0
    for body in robot.bodies:
        reach, above = float(np.linalg.norm(body.hull.vertices, axis=1).max()), body.joint
        while robot.model.names[above] in robot.spec.gripper.joints:
            reach += float(np.linalg.norm(robot.model.jointPlacements[above].translation)) + _slide(robot, above)
            above = robot.model.parents[above]
        if above == joint:
            farthest = max(farthest, reach)
    return farthest


def _slide(robot: RobotModel, joint: int) -> float:
    """How far a joint of the gripper slides from its zero, at most [m]; 0 for one that turns."""
    if robot.model.joints[joint].shortname().startswith("JointModelR"):
        return 0.0
    index = robot.spec.gripper.joints.index(robot.model.names[joint])
    return max(abs(float(robot.linkage.joints(opening)[index])) for opening in robot.linkage.grid)
