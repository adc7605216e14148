"""The robot in PyBullet: its URDF with the planner's hulls, coupled fingers, motors, and what the fingers touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from tamp.errors import RobotError, TaskError
from tamp.execution.pybullet.bodies import MARGIN, eroded, hulls_as_obj, write_obj
from tamp.execution.pybullet.client import pybullet
from tamp.execution.robot.gripper_drive import FINGER_SPEED, GripperDrive, gripper_drive
from tamp.execution.robot.links import LEAST_MASS, LEAST_MOMENT, Link, robot_links
from tamp.task import Pose, RobotSpec
from tamp.task.mesh.mesh_file import binary_stl, read_mesh
from tamp.task.robot import GENTLE_FORCE, PAD_FRICTION
from tamp.world.robot.urdf import link_shapes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

POSITION_GAIN = 0.3
"""Share of a joint's position error that its motor removes in one step."""


COUPLING_FORCE = 200.0
"""Largest force with which joints of the gripper are kept together [N or N m]."""


@dataclass(frozen=True)
class RobotBody:
    """A robot in a PyBullet world.

    Attributes:
        spec: the robot as data.
        client: PyBullet's number of the world.
        id: PyBullet's number of the robot.
        arm, fingers: PyBullet's numbers of the joints of arm and gripper.
        pads: PyBullet's numbers of the links that carry the pads.
        leader: which of `fingers` presses where links swing: the joint that carries all of the first finger.
        drive: what the gripper's motors do for an opening.
        tool_parent: PyBullet's number of the link that carries the tool frame.
        effort: largest torque of each arm joint [N m].
        bodies: object -> PyBullet's number of it.
    """

    spec: RobotSpec
    client: int
    id: int
    arm: tuple[int, ...]
    fingers: tuple[int, ...]
    pads: tuple[int, ...]
    leader: int
    drive: GripperDrive
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
        return self.drive.opening(np.array([state[0] for state in states]))

    def finger_speed(self) -> float:
        """Speed of the fastest finger [m/s]."""
        states = pybullet.getJointStates(self.id, self.fingers, physicsClientId=self.client)
        return self.drive.speed(np.array([s[0] for s in states]), np.array([s[1] for s in states]))

    def tool(self) -> Pose:
        """`T_world_tool` as it is now."""
        state = pybullet.getLinkState(
            self.id, self.tool_parent, computeForwardKinematics=1, physicsClientId=self.client
        )
        return Pose(state[4], state[5]) @ self.spec.T_parent_tool

    def set_state(self, q: Sequence[float] | Vector, opening: float) -> None:
        """Put the arm at `q` [rad] and the fingers at `opening` [m], at rest. For building a scene and for pictures."""
        values = (*q, *self.drive.joints(opening))
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
        speeds = self.drive.velocities(FINGER_SPEED, opening)
        targets = self.drive.joints(opening)
        for k, force in self._forces(GENTLE_FORCE, opening).items():
            pybullet.setJointMotorControl2(
                self.id,
                self.fingers[k],
                pybullet.POSITION_CONTROL,
                targetPosition=targets[k],
                force=force,
                maxVelocity=abs(speeds[k]),
                physicsClientId=self.client,
            )

    def squeeze(self, force: float) -> None:
        """Close the fingers until told otherwise, each with `force` [N]."""
        opening = self.opening()
        speeds = self.drive.velocities(-FINGER_SPEED / 2, opening)
        for k, most in self._forces(force, opening).items():
            pybullet.setJointMotorControl2(
                self.id,
                self.fingers[k],
                pybullet.VELOCITY_CONTROL,
                targetVelocity=speeds[k],
                force=most,
                physicsClientId=self.client,
            )

    def _forces(self, force: float, opening: float) -> dict[int, float]:
        """Of the joints that have motors of their own, with which each finger presses by `force` [N]: all, or one."""
        forces = np.abs(self.drive.forces(force, opening))
        if self.drive.sliding:
            return dict(enumerate(forces.tolist()))
        multipliers = self.drive.multipliers
        return {self.leader: float(forces[self.leader] * (multipliers**2).sum() / (2 * multipliers[self.leader] ** 2))}

    def follow(self) -> None:
        """Let the links of a gripper that swing follow the one that presses, for the next step.

        PyBullet's gears, which couple fingers that slide, give way where thin links press from the side. So the leader
        presses for its own finger, and motors that do not yield keep all others where it is. What the URDF calls the
        driver may be a link beside the fingers, that feels nothing of what they hold: it follows like the others.
        """
        if self.drive.sliding:
            return
        state = pybullet.getJointState(self.id, self.fingers[self.leader], physicsClientId=self.client)
        multipliers, offsets = self.drive.multipliers, self.drive.offsets
        position = (state[0] - offsets[self.leader]) / multipliers[self.leader]
        velocity = state[1] / multipliers[self.leader]
        for k, joint in enumerate(self.fingers):
            if k == self.leader:
                continue
            pybullet.setJointMotorControl2(
                self.id,
                joint,
                pybullet.POSITION_CONTROL,
                targetPosition=multipliers[k] * position + offsets[k],
                targetVelocity=multipliers[k] * velocity,
                positionGain=POSITION_GAIN,
                velocityGain=1.0,
                force=COUPLING_FORCE,
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
            for finger in self.pads:
                for enabled in (0, 1):
                    pybullet.setCollisionFilterPair(
                        self.id, body, finger, -1, enableCollision=enabled, physicsClientId=self.client
                    )

    def touching(self, name: str) -> tuple[bool, ...]:
        """For each finger, whether it touches an object."""
        points = pybullet.getContactPoints(bodyA=self.id, bodyB=self.bodies[name], physicsClientId=self.client)
        links = {p[3] for p in points if p[8] < 0.001}
        return tuple(pad in links for pad in self.pads)


SPINNING_FRICTION = 0.1
"""Resistance of a pad against turning about the contact's normal, as PyBullet counts it."""


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
            str(_resolved_urdf(folder, spec, visible)),
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
    named = [*((j, joints) for j in (*spec.joints, *spec.gripper.joints))]
    for name, known in (*named, *((link, links) for link in (spec.tool_parent, *spec.gripper.fingers))):
        if name not in known:
            raise RobotError(f"{spec.urdf}: there is no {name!r}; the URDF has {', '.join(sorted(known))}")
    arm, fingers = (tuple(joints[name] for name in names) for names in (spec.joints, spec.gripper.joints))
    way = [links[spec.gripper.fingers[0]]]  # a joint has its child's number
    while infos[way[-1]][16] >= 0:
        way.append(infos[way[-1]][16])
    body = RobotBody(
        spec=spec,
        client=client,
        id=robot,
        arm=arm,
        fingers=fingers,
        pads=tuple(links[name] for name in spec.gripper.fingers),
        leader=fingers.index(next(joint for joint in reversed(way) if joint in fingers)),
        drive=gripper_drive(spec),
        tool_parent=links[spec.tool_parent],
        effort=tuple(float(infos[joint][10]) for joint in arm),
    )
    _set_up(body, q)
    return body


def _set_up(body: RobotBody, q: Sequence[float]) -> None:
    body.set_state(q, body.spec.gripper.stroke)
    for pad in body.pads:
        pybullet.changeDynamics(
            body.id,
            pad,
            lateralFriction=PAD_FRICTION,
            spinningFriction=SPINNING_FRICTION,
            frictionAnchor=1,  # as PyBullet's own Panda asks for: what is held creeps away without, as the arm moves
            physicsClientId=body.client,
        )
    if body.drive.sliding:
        _couple(body)
    body.command(q)
    body.open_to(body.spec.gripper.stroke)


def _couple(body: RobotBody) -> None:
    """Keep fingers that slide together: without it the stronger one pushes the object aside."""
    driver, *others = body.fingers
    grip = body.spec.gripper
    for follower, multiplier, offset in zip(others, grip.multipliers[1:], grip.offsets[1:], strict=True):
        gear = pybullet.createConstraint(
            body.id,
            driver,
            body.id,
            follower,
            pybullet.JOINT_GEAR,
            jointAxis=[1, 0, 0],
            parentFramePosition=[0, 0, 0],
            childFramePosition=[0, 0, 0],
            physicsClientId=body.client,
        )
        pybullet.changeConstraint(  # keeps driver + ratio * follower at the target
            gear,
            gearRatio=-1 / multiplier,
            relativePositionTarget=-offset / multiplier,
            erp=0.1,
            maxForce=COUPLING_FORCE,
            physicsClientId=body.client,
        )


def _resolved_urdf(folder: Path, spec: RobotSpec, visible: bool) -> Path:
    """A copy of the URDF as PyBullet should read it.

    Each collision shape becomes the convex hull that the planner sees too, less PyBullet's margin: with it, fingers
    would be 2 mm closer to each other than planned. Links of which the URDF tells no mass get that of their hulls:
    PyBullet would give them 1 kg. What it says of contacts is for Bullet alone, and left out: pads that are springs
    give way by 0.7 mm under 20 N, and what they hold lags behind a hand that turns.
    """
    hulls = iter(_hulls(spec))
    root = ElementTree.fromstring(spec.description)
    solids = {link.name: link for link in robot_links(spec)}
    for link in root.iter("link"):
        for collision in link.findall("collision"):
            path = write_obj(folder, next(hulls))
            collision.clear()
            geometry = ElementTree.SubElement(collision, "geometry")
            ElementTree.SubElement(geometry, "mesh", filename=str(path))
        for contact in link.findall("contact"):
            link.remove(contact)
        for visual in link.findall("visual") if visible else ():
            if not _drawn(folder, visual):
                link.remove(visual)
        solid = solids[link.get("name", "")]
        if not _weighed(link) or (solid.mass == 0.0 and solid.joint is not None and solid.joint.kind != "fixed"):
            _weigh(link, solid)
    path = folder / "robot.urdf"
    path.write_text(ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
    return path


def _drawn(folder: Path, visual: ElementTree.Element) -> bool:
    """Copy a visual mesh that PyBullet cannot read, PLY or STL of text, to one that it can; False if it is no mesh."""
    mesh = visual.find("geometry/mesh")
    path = Path("" if mesh is None else mesh.get("filename", ""))
    if mesh is None or not (path.suffix.lower() == ".ply" or (path.suffix.lower() == ".stl" and not binary_stl(path))):
        return True
    x, y, z = map(float, mesh.attrib.pop("scale", "1 1 1").split())
    try:
        read = read_mesh(path, (x, y, z))
    except TaskError:  # only pictures are the poorer for it
        return False
    corners = (f"v {a:.9g} {b:.9g} {c:.9g}" for a, b, c in read.vertices)
    faces = (f"f {a + 1} {b + 1} {c + 1}" for group in read.groups for a, b, c in group)
    mesh.set("filename", str(write_obj(folder, "\n".join((*corners, *faces, "")))))
    return True


def _weighed(element: ElementTree.Element) -> bool:
    """Whether the URDF tells a link's mass and its moments of inertia."""
    inertia = element.find("inertial/inertia")
    return inertia is not None and all(float(inertia.get(axis, "0")) > 0.0 for axis in ("ixx", "iyy", "izz"))


def _weigh(element: ElementTree.Element, link: Link) -> None:
    for inertial in element.findall("inertial"):
        element.remove(inertial)
    inertial = ElementTree.SubElement(element, "inertial")
    roll, pitch, yaw = link.frame.rpy
    at = {"xyz": " ".join(map(repr, link.frame.xyz)), "rpy": f"{roll!r} {pitch!r} {yaw!r}"}
    ElementTree.SubElement(inertial, "origin", at)
    ElementTree.SubElement(inertial, "mass", value=repr(max(link.mass, LEAST_MASS)))
    x, y, z = (repr(max(moment, LEAST_MOMENT)) for moment in link.moments)
    ElementTree.SubElement(inertial, "inertia", ixx=x, iyy=y, izz=z, ixy="0", ixz="0", iyz="0")


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
