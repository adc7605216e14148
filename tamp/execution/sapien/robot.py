"""The robot in SAPIEN: links with the planner's hulls, motors, coupled fingers, and what the fingers touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.execution.robot.gripper_drive import FINGER_SPEED, GripperDrive, gripper_drive
from tamp.execution.robot.links import LEAST_MASS, LEAST_MOMENT, Joint, Link, merged_fingers
from tamp.execution.sapien.bodies import ROBOT_GROUP, add_hull, fixed_material, from_sapien, set_inertia, to_sapien
from tamp.execution.sapien.client import physx, sapien
from tamp.execution.simulator import STEP
from tamp.task import Pose, RobotSpec
from tamp.task.robot import GENTLE_FORCE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

ARMATURE = 0.1
"""Inertia of a motor's rotor as its joint feels it [kg m^2]."""

STIFFNESS, DAMPING = 10000.0, 200.0
"""Of a joint's servo for each unit of inertia [1/s^2], [1/s]; its torque is not limited."""


COUPLING_STIFFNESS, COUPLING_DAMPING, COUPLED_ARMATURE = 200.0, 0.5, 0.002
"""Of what keeps links that swing where the others are [N m/rad], [N m s/rad], and their motors' inertia [kg m^2].

PhysX's tendons, which couple fingers that slide, let such links drift open while they squeeze; and so do drives that
are much stiffer than this for the inertia.
"""


class SapienRobot:
    """A robot in a SAPIEN world; see tamp.execution.simulator.Robot.

    Raises:
        RobotError: where the URDF cannot be used.
    """

    def __init__(self, scene: Any, system: Any, spec: RobotSpec, q: Sequence[float]) -> None:
        self._system, self._spec, self._drive = system, spec, gripper_drive(spec)
        self.links = _add_links(scene, spec, self._drive)
        self._articulation = next(iter(self.links.values())).articulation
        names = [joint.name for joint in self._articulation.active_joints]
        self._arm = np.array([names.index(name) for name in spec.joints])
        self._fingers = np.array([names.index(name) for name in spec.gripper.joints])
        joints = self._articulation.active_joints
        self._arm_joints = [joints[i] for i in self._arm]
        self._finger_joints = [joints[i] for i in self._fingers]
        self._swinging = not self._drive.sliding
        self._pads = tuple(self.links[name] for name in spec.gripper.fingers)
        self.objects: Mapping[str, Any] = {}
        start = np.zeros(len(names), dtype=np.float32)
        start[self._arm], start[self._fingers] = q, self._drive.joints(spec.gripper.stroke)
        self._articulation.qpos = start
        for joint in self._arm_joints:
            joint.set_drive_properties(STIFFNESS, DAMPING, mode="acceleration")
        self._target: float | None = None
        self.command(q)
        self.open_to(spec.gripper.stroke)

    @property
    def spec(self) -> RobotSpec:
        """The robot as data."""
        return self._spec

    def configuration(self) -> Vector:
        """Arm joint positions, shape (joints,) [rad]."""
        return np.array(self._articulation.qpos[self._arm], dtype=np.float64)

    def opening(self) -> float:
        """Distance between the finger pads [m]."""
        return self._drive.opening(np.array(self._articulation.qpos[self._fingers], dtype=np.float64))

    def finger_speed(self) -> float:
        """Speed of the fastest finger [m/s]."""
        state = (np.array(v[self._fingers], np.float64) for v in (self._articulation.qpos, self._articulation.qvel))
        return self._drive.speed(*state)

    def tool(self) -> Pose:
        """`T_world_tool` as it is now."""
        return from_sapien(self.links[self._spec.tool_parent].entity_pose) @ self._spec.T_parent_tool

    def command(self, q: Sequence[float] | Vector, velocity: Sequence[float] | Vector | None = None) -> None:
        """Send the arm to `q` [rad], with `velocity` [rad/s] fed forward."""
        self._q = np.array(q, dtype=np.float64)
        self._v = np.zeros(len(self._q)) if velocity is None else np.array(velocity, dtype=np.float64)

    def open_to(self, opening: float) -> None:
        """Send the fingers to `opening` [m]; they push gently."""
        self._target, self._now = opening, self.opening()
        self._force = 0.0
        drive = self._drive
        for joint, force in zip(self._finger_joints, drive.forces(GENTLE_FORCE, opening), strict=True):
            joint.set_drive_properties(drive.stiffness, drive.damping, float(abs(force)), "force")
            joint.set_drive_velocity_target(0.0)

    def squeeze(self, force: float) -> None:
        """Close the fingers until told otherwise, each with `force` [N], against a damper: a servo would chatter."""
        opening = self.opening()
        self._target, self._force = None, -force
        damping = self._drive.damping_at(force, opening, FINGER_SPEED / 2)
        if self._swinging:
            self._damping = damping
            for joint in self._finger_joints:
                joint.set_drive_properties(COUPLING_STIFFNESS, COUPLING_DAMPING, 1e6, "force")
            return
        for joint, resistance in zip(self._finger_joints, damping, strict=True):
            joint.set_drive_properties(0.0, float(resistance), 1e6, "force")
            joint.set_drive_velocity_target(0.0)

    def drive(self, since: float, dt: float) -> None:
        """Set the motors for the next `dt` [s], `since` [s] after the arm was told where to be.

        PhysX solves a drive for the end of its step.
        """
        at = self._q + self._v * min(since + dt, STEP)
        for joint, q, v in zip(self._arm_joints, at, self._v, strict=True):
            joint.set_drive_target(float(q))
            joint.set_drive_velocity_target(float(v))
        forces = self._articulation.compute_passive_force(True, True)
        if self._target is None:
            forces[self._fingers] += self._drive.balance(self._force, self.opening())
            if self._swinging:
                forces[self._fingers] += self._together(dt)
        else:
            way = 2.0 * FINGER_SPEED * dt
            self._now += float(np.clip(self._target - self._now, -way, way))
            for joint, position in zip(self._finger_joints, self._drive.joints(self._now), strict=True):
                joint.set_drive_target(float(position))
        self._articulation.qf = forces

    def _together(self, dt: float) -> Vector:
        """Send each link of the gripper to where all are on average, for the next `dt` [s]; the damper's torques."""
        drive, (q, v) = self._drive, (self._articulation.qpos[self._fingers], self._articulation.qvel[self._fingers])
        at, rate = float(np.mean((q - drive.offsets) / drive.multipliers)), float(np.mean(v / drive.multipliers))
        speeds = drive.multipliers * rate
        for joint, target, speed in zip(
            self._finger_joints, drive.multipliers * (at + rate * dt) + drive.offsets, speeds, strict=True
        ):
            joint.set_drive_target(float(target))
            joint.set_drive_velocity_target(float(speed))
        found: Vector = -self._damping * speeds
        return found

    def touching(self, name: str) -> tuple[bool, ...]:
        """For each finger, whether it touches an object."""
        mine, touched = self.objects[name], set()
        for contact in self._system.get_contacts():
            first, second = contact.bodies
            if mine in (first, second) and any(point.separation < 0.001 for point in contact.points):
                touched |= {i for i, pad in enumerate(self._pads) if pad in (first, second)}
        return tuple(i in touched for i in range(len(self._pads)))


def _add_links(scene: Any, spec: RobotSpec, drive: GripperDrive) -> dict[str, Any]:
    """The robot's links by name, its base fixed."""
    made: dict[str, Any] = {}
    moved: dict[str, Any] = {}
    entities = []
    surface, finger_armature = fixed_material(), drive.armature if drive.sliding else COUPLED_ARMATURE
    links, part_of = merged_fingers(spec)  # tendons run through joints that move, and no others
    for link in links:
        body = physx.PhysxArticulationLinkComponent(None if link.parent is None else made[link.parent])
        for hull in link.hulls:
            add_hull(body, hull, surface, ROBOT_GROUP)
        if link.hulls:
            set_inertia(body, link.mass, link.frame, link.moments)
        else:
            set_inertia(body, LEAST_MASS, Pose(), (LEAST_MOMENT,) * 3)  # PhysX takes no link without mass
        entity = sapien.Entity()
        entity.add_component(body)
        entity.name = body.name = link.name
        armature = finger_armature if link.joint and link.joint.name in spec.gripper.joints else ARMATURE
        _set_joint(body.joint, link, link.joint, armature)
        if link.joint is not None:
            moved[link.joint.name] = body
        if link.parent is None:
            entity.pose = to_sapien(link.pose)
        made[link.name] = body
        entities.append(entity)
    driver, grip = moved[spec.gripper.joints[0]], spec.gripper
    followers = zip(grip.joints[1:], grip.multipliers[1:], grip.offsets[1:], strict=True)
    for name, multiplier, offset in followers if drive.sliding else ():
        chain = _tendon(driver, moved[name])
        ratio = [-multiplier if link is driver else float(link is moved[name]) for link in chain]
        driver.articulation.create_fixed_tendon(chain, ratio, ratio, rest_length=offset, stiffness=1e5)
    for entity in entities:
        scene.add_entity(entity)
    return {name: made[whole] for name, whole in part_of.items()}


def _tendon(driver: Any, follower: Any) -> list[Any]:
    """The links that a tendon between two links runs through: from the nearest that carries both, parents first."""
    above = [driver]
    while above[-1].parent is not None:
        above.append(above[-1].parent)
    way = [follower]
    while way[-1] not in above:
        way.append(way[-1].parent)
    root = way[-1].parent if way[-1] is driver else way[-1]  # a tendon begins where nothing counts yet
    down = [root, *reversed(above[: above.index(root)])]
    return down + [link for link in reversed(way) if link not in down]


def _set_joint(joint: Any, link: Link, told: Joint | None, armature: float) -> None:
    if told is None or told.kind == "fixed":
        joint.type = "fixed"
        if told is not None:
            joint.pose_in_parent, joint.pose_in_child = to_sapien(link.pose), sapien.Pose()
        return
    frame = Pose(quat=_from_x(told.axis))
    joint.name, joint.type = told.name, told.kind
    joint.pose_in_parent, joint.pose_in_child = to_sapien(link.pose @ frame), to_sapien(frame)
    joint.limit = np.array([[told.lower, told.upper]], dtype=np.float32)
    joint.armature = np.array([armature], dtype=np.float32)
    joint.friction = 0.0


def _from_x(axis: Sequence[float]) -> tuple[float, float, float, float]:
    """The rotation that takes the x axis, about which PhysX's joints turn, to `axis`, as (x, y, z, w)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    if x < -0.999999:
        return 0.0, 0.0, 1.0, 0.0
    return 0.0, -float(z), float(y), 1.0 + float(x)
