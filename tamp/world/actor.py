"""Who moves in an arena: the whole robot, or its hand alone as a body that flies free."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from tamp.world.robot_model import RobotModel
from tamp.world.solid import Solid, solid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Actor:
    """What moves: a whole robot, or a hand alone.

    Attributes:
        model: Pinocchio's model.
        names, joints, solids: name, joint and shape (in the joint's frame) of each body.
        pairs: indices of bodies that may collide with each other.
        tool_joint: the joint that a held object is attached to.
        T_joint_tool: tool frame in that joint's frame.
        grip: bodies that may touch what is held.
    """

    model: Any
    names: tuple[str, ...]
    joints: tuple[int, ...]
    solids: tuple[Solid, ...]
    pairs: tuple[tuple[int, int], ...]
    tool_joint: int
    T_joint_tool: Matrix
    grip: frozenset[int]


@cache
def robot_actor(robot: RobotModel) -> Actor:
    """The robot with all its links; its configuration is Pinocchio's."""
    return Actor(
        model=robot.model,
        names=tuple(body.name for body in robot.bodies),
        joints=tuple(body.joint for body in robot.bodies),
        solids=tuple(solid([body.hull]) for body in robot.bodies),
        pairs=robot.pairs,
        tool_joint=robot.tool_joint,
        T_joint_tool=robot.T_joint_tool,
        grip=frozenset(robot.hand),
    )


@cache
def hand_actor(robot: RobotModel) -> Actor:
    """Hand and fingers on a free joint in place of the tool's; see `hand_configuration`."""
    model = pin.Model()
    free = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "tool")
    joint_of = {robot.tool_joint: free}
    for name in robot.spec.gripper.joints:
        joint = robot.model.getJointId(name)
        placement = robot.model.jointPlacements[joint]
        joint_of[joint] = model.addJoint(free, robot.model.joints[joint], placement, name)
    bodies = [robot.bodies[i] for i in robot.hand]
    return Actor(
        model=model,
        names=tuple(body.name for body in bodies),
        joints=tuple(joint_of[body.joint] for body in bodies),
        solids=tuple(solid([body.hull]) for body in bodies),
        pairs=(),
        tool_joint=free,
        T_joint_tool=robot.T_joint_tool,
        grip=frozenset(range(len(bodies))),
    )


def hand_configuration(hand: Actor, T_world_tool: Matrix, opening: float) -> Vector:
    """The free hand's configuration with its tool at `T_world_tool` and the pads `opening` [m] apart."""
    T_world_joint = pin.SE3(T_world_tool) * pin.SE3(hand.T_joint_tool).inverse()
    return np.concatenate([pin.SE3ToXYZQUAT(T_world_joint), np.full(hand.model.nq - 7, opening / 2)])
