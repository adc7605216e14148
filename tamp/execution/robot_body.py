"""The robot in PyBullet: the motors of arm and fingers, where they are, and what the fingers touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.bullet import pybullet
from tamp.task import Pose, RobotSpec
from tamp.task.robot import GENTLE_FORCE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

POSITION_GAIN = 0.3
"""Share of a joint's position error that its motor removes in one step."""

FINGER_SPEED = 0.1
"""How fast a finger moves [m/s]."""


@dataclass(frozen=True)
class RobotBody:
    """A robot in a PyBullet world.

    Attributes:
        spec: the robot as data.
        client: PyBullet's number of the world.
        id: PyBullet's number of the robot.
        arm, fingers: PyBullet's numbers of the joints, which are those of the links they move.
        tool_parent: PyBullet's number of the link that carries the tool frame.
        effort: largest torque of each arm joint [N m].
    """

    spec: RobotSpec
    client: int
    id: int
    arm: tuple[int, ...]
    fingers: tuple[int, ...]
    tool_parent: int
    effort: tuple[float, ...]

    def configuration(self) -> Vector:
        """Arm joint positions, shape (joints,) [rad]."""
        states = pybullet.getJointStates(self.id, self.arm, physicsClientId=self.client)
        return np.array([state[0] for state in states])

    def joint_speed(self) -> float:
        """Speed of the fastest arm joint [rad/s]."""
        states = pybullet.getJointStates(self.id, self.arm, physicsClientId=self.client)
        return max(abs(float(state[1])) for state in states)

    def opening(self) -> float:
        """Distance between the finger pads [m]."""
        states = pybullet.getJointStates(self.id, self.fingers, physicsClientId=self.client)
        return 2.0 * sum(float(state[0]) for state in states) / len(states)

    def finger_speed(self) -> float:
        """Speed of the fastest finger [m/s]."""
        states = pybullet.getJointStates(self.id, self.fingers, physicsClientId=self.client)
        return max(abs(float(state[1])) for state in states)

    def tool(self) -> Pose:
        """`T_world_tool` as it is now."""
        state = pybullet.getLinkState(
            self.id, self.tool_parent, computeForwardKinematics=1, physicsClientId=self.client
        )
        return Pose(state[4], state[5]) @ self.spec.T_parent_tool

    def set_state(self, q: Sequence[float] | Vector, opening: float) -> None:
        """Put the arm at `q` [rad] and the fingers at `opening` [m], at rest. For building a scene and for pictures."""
        values = (*q, *(opening / 2 for _ in self.fingers))
        for joint, value in zip((*self.arm, *self.fingers), values, strict=True):
            pybullet.resetJointState(self.id, joint, value, physicsClientId=self.client)

    def command(self, q: Sequence[float] | Vector, velocity: Sequence[float] | Vector | None = None) -> None:
        """Send the arm to `q` [rad], with `velocity` [rad/s] fed forward."""
        pybullet.setJointMotorControlArray(
            self.id,
            self.arm,
            pybullet.POSITION_CONTROL,
            targetPositions=list(q),
            targetVelocities=[0.0] * len(self.arm) if velocity is None else list(velocity),
            positionGains=[POSITION_GAIN] * len(self.arm),
            velocityGains=[1.0] * len(self.arm),
            forces=self.effort,
            physicsClientId=self.client,
        )

    def open_to(self, opening: float) -> None:
        """Send the fingers to `opening` [m]; they push gently."""
        for joint in self.fingers:
            pybullet.setJointMotorControl2(
                self.id,
                joint,
                pybullet.POSITION_CONTROL,
                targetPosition=opening / 2,
                force=GENTLE_FORCE,
                maxVelocity=FINGER_SPEED,
                physicsClientId=self.client,
            )

    def squeeze(self, force: float) -> None:
        """Close the fingers until told otherwise, each with `force` [N]."""
        for joint in self.fingers:
            pybullet.setJointMotorControl2(
                self.id,
                joint,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=-FINGER_SPEED / 2,
                force=force,
                physicsClientId=self.client,
            )

    def touching(self, body: int) -> tuple[bool, ...]:
        """For each finger, whether it touches a body."""
        points = pybullet.getContactPoints(bodyA=self.id, bodyB=body, physicsClientId=self.client)
        links = {p[3] for p in points if p[8] < 0.001}
        return tuple(finger in links for finger in self.fingers)
