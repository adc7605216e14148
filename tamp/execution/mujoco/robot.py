"""The robot in MuJoCo: the URDF's links with the planner's hulls, coupled fingers, motors, and what the fingers touch.

Motors have the inertia of their rotors, as geared ones do, and the weight of the arm is taken off them, as a robot's
own controller does it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from tamp.errors import RobotError
from tamp.execution.mujoco.bodies import ROBOT, SOLIMP, SOLREF, Friction, add_hull, set_inertia, wxyz
from tamp.execution.robot.gripper_drive import FINGER_SPEED, gripper_drive
from tamp.execution.robot.links import LEAST_MASS, LEAST_MOMENT, Joint, robot_links
from tamp.execution.simulator import STEP
from tamp.task import Pose, RobotSpec
from tamp.task.robot import GENTLE_FORCE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

ARMATURE = 0.1
"""Inertia of a motor's rotor as its joint feels it [kg m^2]."""

BANDWIDTH = 100.0
"""Natural frequency of a joint's servo, which is damped critically [rad/s]."""

KINDS = {"revolute": mujoco.mjtJoint.mjJNT_HINGE, "prismatic": mujoco.mjtJoint.mjJNT_SLIDE}


def add_robot(spec: Any, robot: RobotSpec) -> None:
    """Add a robot to a model in the making, its base fixed; joints keep the URDF's names.

    Raises:
        RobotError: where the URDF cannot be used.
    """
    bodies: dict[str, Any] = {}
    drive = gripper_drive(robot)
    for link in robot_links(robot):
        parent = spec.worldbody if link.parent is None else bodies[link.parent]
        body = parent.add_body(name=body_name(link.name), pos=link.pose.xyz, quat=wxyz(link.pose), gravcomp=1.0)
        bodies[link.name] = body
        for hull in link.hulls:
            add_hull(spec, body, hull, Friction(group=ROBOT))
        if link.hulls:
            set_inertia(body, link.mass, link.frame, link.moments)
        elif link.joint is not None and link.joint.kind in KINDS:
            set_inertia(body, LEAST_MASS, Pose(), (LEAST_MOMENT,) * 3)
        if link.joint is not None and link.joint.kind in KINDS:
            _add_joint(spec, body, link.joint, robot, drive.armature)
    grip = robot.gripper
    for i, name in enumerate(grip.joints[1:], 1):  # without it the stronger finger pushes the object aside
        gear = spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT, name1=name, name2=grip.joints[0], solref=list(SOLREF), solimp=list(SOLIMP)
        )
        gear.objtype = mujoco.mjtObj.mjOBJ_JOINT
        gear.data[:2] = grip.offsets[i], grip.multipliers[i]  # of the polynomial that gives one from the other


def body_name(link: str) -> str:
    """What a link is called in the model: the URDF may have a world, a table and a floor of its own."""
    return f"link {link}"


def _add_joint(spec: Any, body: Any, joint: Joint, robot: RobotSpec, finger_armature: float) -> None:
    limited = math.isfinite(joint.lower) and math.isfinite(joint.upper)
    body.add_joint(
        name=joint.name,
        type=KINDS[joint.kind],
        axis=joint.axis,
        armature=ARMATURE if joint.name in robot.joints else finger_armature,
        limited=limited,
        range=[joint.lower, joint.upper] if limited else [0.0, 0.0],
    )
    motor = spec.add_actuator(
        name=joint.name,
        target=joint.name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
    )
    # Of the fingers the robot's data says how hard they may press, wherever the URDF says less.
    if joint.name in robot.joints and joint.effort is not None:
        motor.forcelimited, motor.forcerange = True, [-joint.effort, joint.effort]


@dataclass
class _Fingers:
    """What the fingers were told: to go to an opening, or to squeeze.

    Attributes:
        target: the opening they go to [m], or None where they squeeze.
        now: the opening that the set point is at by now [m]; it moves at the fingers' speed.
        force: with which each finger squeezes, outwards [N].
    """

    target: float | None
    now: float
    force: float = 0.0


class MuJoCoRobot:
    """A robot in a MuJoCo world; see tamp.execution.simulator.Robot.

    Args:
        spec: the robot as data.
        model, data: MuJoCo's, with the robot in it.
        geoms: object -> MuJoCo's numbers of its geoms.
        q: arm configuration to start from [rad].
    """

    def __init__(
        self, spec: RobotSpec, model: Any, data: Any, geoms: Mapping[str, frozenset[int]], q: Sequence[float]
    ) -> None:
        links = (body_name(spec.tool_parent),)
        for kind, names in (("joint", (*spec.joints, *spec.gripper.joints)), ("body", links)):
            for name in names:
                if mujoco.mj_name2id(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), name) < 0:
                    raise RobotError(f"{spec.urdf}: there is no {name!r} that MuJoCo could use")
        self._spec, self._model, self._data, self._geoms = spec, model, data, geoms
        self._arm, self._fingers = (
            np.array([model.joint(name).qposadr[0] for name in names]) for names in (spec.joints, spec.gripper.joints)
        )
        self._arm_v, self._fingers_v = (
            np.array([model.joint(name).dofadr[0] for name in names]) for names in (spec.joints, spec.gripper.joints)
        )
        self._arm_u, self._fingers_u = (
            np.array([model.actuator(name).id for name in names]) for names in (spec.joints, spec.gripper.joints)
        )
        self._pads = tuple(
            frozenset(np.flatnonzero(model.geom_bodyid == model.body(body_name(name)).id).tolist())
            for name in spec.gripper.fingers
        )
        self._drive = gripper_drive(spec)
        self._armature = np.array(model.dof_armature)
        self._tune()
        data.qpos[self._arm], data.qpos[self._fingers] = q, self._drive.joints(spec.gripper.stroke)
        self.command(q)
        self._told = _Fingers(None, 0.0)
        self.open_to(spec.gripper.stroke)

    def _tune(self) -> None:
        """Servos as stiff as the inertia that each joint has at home allows."""
        model, data = self._model, self._data
        data.qpos[self._arm] = self._spec.home
        mujoco.mj_forward(model, data)
        own = np.empty(len(self._arm_v))
        for i, joint in enumerate(self._arm_v):
            unit, column = np.zeros(model.nv), np.empty(model.nv)
            unit[joint] = 1.0
            mujoco.mj_mulM(model, data, column, unit)
            own[i] = column[joint]
        stiffness, damping = own * BANDWIDTH**2, 2 * own * BANDWIDTH
        self._lead = damping / stiffness
        model.actuator_gainprm[self._arm_u, 0] = stiffness
        model.actuator_biasprm[self._arm_u, 1] = -stiffness
        self._damp(self._arm_u, self._arm_v, damping)

    def _damp(self, motors: Vector, joints: Vector, damping: Vector | float) -> None:
        """Damp joints by their motors [N m s/rad or N s/m], implicitly in the velocity.

        For that a joint gets the inertia that its damping comes to in a step. MuJoCo's implicit integrators do the same
        after the contacts were solved, which then meet other accelerations than they were solved for: what is held
        lags behind the hand.
        """
        self._model.actuator_biasprm[motors, 2] = -damping
        self._model.dof_armature[joints] = self._armature[joints] + damping * self._model.opt.timestep

    @property
    def spec(self) -> RobotSpec:
        """The robot as data."""
        return self._spec

    def configuration(self) -> Vector:
        """Arm joint positions, shape (joints,) [rad]."""
        return np.array(self._data.qpos[self._arm])

    def opening(self) -> float:
        """Distance between the finger pads [m]."""
        return self._drive.opening(self._data.qpos[self._fingers])

    def finger_speed(self) -> float:
        """Speed of the fastest finger [m/s]."""
        return self._drive.speed(self._data.qpos[self._fingers], self._data.qvel[self._fingers_v])

    def tool(self) -> Pose:
        """`T_world_tool` as it is now."""
        return self.link(self._spec.tool_parent) @ self._spec.T_parent_tool

    def link(self, name: str) -> Pose:
        """`T_world_link` of one of the URDF's links as it is now."""
        mujoco.mj_kinematics(self._model, self._data)
        body = self._model.body(body_name(name)).id
        w, x, y, z = self._data.xquat[body]
        return Pose(tuple(self._data.xpos[body]), (x, y, z, w))

    def command(self, q: Sequence[float] | Vector, velocity: Sequence[float] | Vector | None = None) -> None:
        """Send the arm to `q` [rad], with `velocity` [rad/s] fed forward."""
        self._q = np.array(q, dtype=np.float64)
        self._v = np.zeros(len(self._q)) if velocity is None else np.array(velocity, dtype=np.float64)

    def open_to(self, opening: float) -> None:
        """Send the fingers to `opening` [m]; they push gently."""
        model, motors = self._model, self._fingers_u
        self._told = _Fingers(opening, self.opening())
        model.actuator_gainprm[motors, 0] = self._drive.stiffness
        model.actuator_biasprm[motors, 1] = -self._drive.stiffness
        self._damp(motors, self._fingers_v, self._drive.damping)
        gentle = np.abs(self._drive.forces(GENTLE_FORCE, opening))
        model.actuator_forcelimited[motors] = True
        model.actuator_forcerange[motors] = np.stack([-gentle, gentle], axis=1)

    def squeeze(self, force: float) -> None:
        """Close the fingers until told otherwise, each with `force` [N], against a damper: a servo would chatter."""
        model, motors = self._model, self._fingers_u
        self._told = _Fingers(None, 0.0)
        model.actuator_gainprm[motors, 0] = 1.0
        model.actuator_biasprm[motors, 1] = 0.0
        opening = self.opening()
        self._damp(motors, self._fingers_v, self._drive.damping_at(force, opening, FINGER_SPEED / 2))
        model.actuator_forcelimited[motors] = False
        self._told.force = -force

    def drive(self, since: float, dt: float) -> None:
        """Set the motors for the next `dt` [s], `since` [s] after the arm was told where to be."""
        at = min(since, STEP)
        self._data.ctrl[self._arm_u] = self._q + self._v * at + self._lead * self._v
        told = self._told
        if told.target is not None:
            way = 2.0 * FINGER_SPEED * dt
            told.now += float(np.clip(told.target - told.now, -way, way))
            self._data.ctrl[self._fingers_u] = self._drive.joints(told.now)
        else:
            self._data.ctrl[self._fingers_u] = self._drive.balance(told.force, self.opening())

    def touching(self, name: str) -> tuple[bool, ...]:
        """For each finger, whether it touches an object."""
        contacts, mine = self._data.contact, self._geoms[name]
        pairs = [(int(a), int(b)) for a, b in contacts.geom]
        return tuple(any((a in pad and b in mine) or (b in pad and a in mine) for a, b in pairs) for pad in self._pads)
