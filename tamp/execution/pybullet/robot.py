"""The robot in PyBullet: its URDF with the planner's hulls, coupled fingers, motors, and what the fingers touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from tamp.errors import RobotError
from tamp.execution.pybullet.bodies import MARGIN, eroded, hulls_as_obj, write_obj
from tamp.execution.pybullet.client import pybullet
from tamp.task import Pose, RobotSpec
from tamp.task.robot import GENTLE_FORCE, PAD_FRICTION
from tamp.world.robot.urdf import link_shapes

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
        bodies: object -> PyBullet's number of it.
    """

    spec: RobotSpec
    client: int
    id: int
    arm: tuple[int, ...]
    fingers: tuple[int, ...]
    tool_parent: int
    effort: tuple[float, ...]
    bodies: Mapping[str, int] = field(default_factory=dict)

    def configuration(self) -> Vector:
        """Arm joint positions, shape (joints,) [rad]."""
        states = pybullet.getJointStates(self.id, self.arm, physicsClientId=self.client)
        return np.array([state[0] for state in states])

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

    def hand_orientation(self) -> Pose:
        """How the link that carries the tool is turned, without its position."""
        state = pybullet.getLinkState(self.id, self.tool_parent, physicsClientId=self.client)
        return Pose(quat=state[5])

    def forget_contacts(self) -> None:
        """Throw away the contact points between fingers and what they touch; they are found anew in the next step."""
        points = pybullet.getContactPoints(bodyA=self.id, physicsClientId=self.client)
        for body in sorted({point[2] for point in points}):
            for finger in self.fingers:
                for enabled in (0, 1):
                    pybullet.setCollisionFilterPair(
                        self.id, body, finger, -1, enableCollision=enabled, physicsClientId=self.client
                    )

    def touching(self, name: str) -> tuple[bool, ...]:
        """For each finger, whether it touches an object."""
        points = pybullet.getContactPoints(bodyA=self.id, bodyB=self.bodies[name], physicsClientId=self.client)
        links = {p[3] for p in points if p[8] < 0.001}
        return tuple(finger in links for finger in self.fingers)


SPINNING_FRICTION = 0.1
"""Resistance of a pad against turning about the contact's normal, as PyBullet counts it."""

COUPLING_FORCE = 200.0
"""Largest force of the gear that keeps two fingers at equal distances from the middle [N]."""


def load_robot_body(
    client: int, folder: Path, spec: RobotSpec, q: Sequence[float], *, visible: bool = False
) -> RobotBody:
    """Add a robot to a world, its base fixed, its arm at `q` [rad], its fingers open.

    Args:
        client: PyBullet's number of the world.
        folder: where files for PyBullet may be written; must live as long as the world.
        spec: the robot as data.
        q: arm configuration to start from [rad].
        visible: whether it can be drawn; its visual meshes take a second to load.

    Raises:
        RobotError: where the URDF cannot be read or lacks a joint or link that the robot names.
    """
    try:
        robot = pybullet.loadURDF(
            str(_resolved_urdf(folder, spec)),
            spec.T_world_base.xyz,
            spec.T_world_base.quat,
            useFixedBase=True,
            flags=0 if visible else pybullet.URDF_IGNORE_VISUAL_SHAPES,
            physicsClientId=client,
        )
    except pybullet.error as error:
        raise RobotError(f"{spec.urdf}: PyBullet cannot load it: {error}") from error
    infos = [
        pybullet.getJointInfo(robot, joint, physicsClientId=client)
        for joint in range(pybullet.getNumJoints(robot, physicsClientId=client))
    ]
    joints = {info[1].decode(): info[0] for info in infos}
    links = {info[12].decode(): info[0] for info in infos}
    for name, known in (*((j, joints) for j in (*spec.joints, *spec.gripper.joints)), (spec.tool_parent, links)):
        if name not in known:
            raise RobotError(f"{spec.urdf}: there is no {name!r}; the URDF has {', '.join(sorted(known))}")
    arm = tuple(joints[name] for name in spec.joints)
    body = RobotBody(
        spec=spec,
        client=client,
        id=robot,
        arm=arm,
        fingers=tuple(joints[name] for name in spec.gripper.joints),
        tool_parent=links[spec.tool_parent],
        effort=tuple(float(infos[joint][10]) for joint in arm),
    )
    _set_up(body, q)
    return body


def _set_up(body: RobotBody, q: Sequence[float]) -> None:
    body.set_state(q, body.spec.gripper.stroke)
    for finger in body.fingers:
        pybullet.changeDynamics(
            body.id,
            finger,
            lateralFriction=PAD_FRICTION,
            spinningFriction=SPINNING_FRICTION,
            physicsClientId=body.client,
        )
    if len(body.fingers) == 2:
        _couple(body)
    body.command(q)
    body.open_to(body.spec.gripper.stroke)


def _couple(body: RobotBody) -> None:
    """Keep both fingers at the same distance from the middle: without it the stronger pushes the object aside."""
    left, right = body.fingers
    gear = pybullet.createConstraint(
        body.id,
        left,
        body.id,
        right,
        pybullet.JOINT_GEAR,
        jointAxis=[1, 0, 0],
        parentFramePosition=[0, 0, 0],
        childFramePosition=[0, 0, 0],
        physicsClientId=body.client,
    )
    pybullet.changeConstraint(gear, gearRatio=-1, erp=0.1, maxForce=COUPLING_FORCE, physicsClientId=body.client)


def _resolved_urdf(folder: Path, spec: RobotSpec) -> Path:
    """A copy of the URDF as PyBullet should read it.

    Each collision shape becomes the convex hull that the planner sees too, less PyBullet's margin: with it, fingers
    would be 2 mm closer to each other than planned. Visual meshes get absolute paths: PyBullet guesses what
    `package://` means.
    """
    hulls = iter(_hulls(spec))
    tree = ElementTree.parse(spec.urdf)
    for link in tree.iter("link"):
        for collision in link.findall("collision"):
            path = write_obj(folder, next(hulls))
            collision.clear()
            geometry = ElementTree.SubElement(collision, "geometry")
            ElementTree.SubElement(geometry, "mesh", filename=str(path))
        for mesh in link.iterfind("visual/geometry/mesh"):
            name = mesh.get("filename", "")
            root = spec.mesh_root if name.startswith("package://") else spec.urdf.parent
            mesh.set("filename", str(root / name.removeprefix("package://")))
    path = folder / "robot.urdf"
    tree.write(path, encoding="unicode")
    return path


@lru_cache(maxsize=16)
def _hulls(spec: RobotSpec) -> tuple[str, ...]:
    """An OBJ file for each collision shape of the URDF, in file order.

    Fingers are drawn in face by face, since a pad that is tilted by half a millimetre presses on one corner only, and
    what it holds turns. The hulls of other links, which hold nothing, keep their few vertices.
    """
    fingers = spec.gripper.fingers
    return tuple(
        hulls_as_obj((eroded(shape.hull),), margin=0.0)
        if shape.link in fingers
        else hulls_as_obj((shape.hull,), MARGIN)
        for shape in link_shapes(spec)
    )
