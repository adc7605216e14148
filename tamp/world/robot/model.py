"""A robot ready to compute with: Pinocchio's model, a convex hull per link, and which pairs of links may collide."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from tamp.task.mesh.cache import cached, content_key
from tamp.task.mesh.parts import Part
from tamp.task.robot import RobotSpec
from tamp.world.geometry.convex_union import solid
from tamp.world.robot.linkage import Linkage, linkage
from tamp.world.robot.urdf import carried, link_shapes, without_shapes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]

SAMPLES = 5000
NEAR = 0.03
"""Two links that never come closer than this [m] in all samples are taken never to collide."""

OVERSHOT = 0.01
"""How far beyond its limit a joint's motor may come to rest [rad]."""


def self_collision_pairs(robot: RobotModel) -> tuple[tuple[int, int], ...]:
    """Pairs of bodies (i < j) that can collide: not neighbours, not overlapping by construction, not always apart."""
    content = b"".join(body.hull.vertices.tobytes() + bytes([body.joint]) for body in robot.bodies)
    key = content_key("self-pairs-4", robot.spec.description.encode(), content, repr(robot.spec))
    stored = cached("self-collision", key, lambda: {"pairs": _sample_pairs(robot)})
    return tuple((int(a), int(b)) for a, b in stored["pairs"])


def _sample_pairs(robot: RobotModel) -> NDArray[np.int64]:
    hand = set(robot.hand)
    geometry = pin.GeometryModel()
    for i, body in enumerate(robot.bodies):
        geometry.addGeometryObject(pin.GeometryObject(str(i), body.joint, pin.SE3.Identity(), solid([body.hull]).hull))
    candidates = [
        (i, j)
        for j in range(len(robot.bodies))
        for i in range(j)
        if robot.bodies[i].joint not in (robot.model.parents[robot.bodies[j].joint], robot.bodies[j].joint)
        and not {i, j} <= hand
        and not robot.spec.may_touch(robot.bodies[i].name, robot.bodies[j].name)
    ]
    for i, j in candidates:
        geometry.addCollisionPair(pin.CollisionPair(i, j))
    return np.array(_possible(robot, geometry, candidates), dtype=np.int64).reshape(-1, 2)


def _possible(robot: RobotModel, geometry: Any, candidates: list[tuple[int, int]]) -> list[tuple[int, int]]:
    data, near = robot.model.createData(), geometry.createData()
    touching = geometry.createData()
    for request in near.collisionRequests:
        request.security_margin = NEAR
    rng = np.random.default_rng(0)
    if not candidates:
        return []
    close, hits = np.zeros(len(candidates), dtype=int), np.zeros(len(candidates), dtype=int)
    for _ in range(SAMPLES):
        q = robot.full(rng.uniform(robot.lower, robot.upper), rng.uniform(0.0, robot.spec.gripper.stroke))
        pin.computeCollisions(robot.model, data, geometry, near, q, False)
        close += [result.isCollision() for result in near.collisionResults]
        pin.computeCollisions(robot.model, data, geometry, touching, q, False)
        hits += [result.isCollision() for result in touching.collisionResults]
    return [pair for k, pair in enumerate(candidates) if close[k] and hits[k] < 0.95 * SAMPLES]


@dataclass(frozen=True, eq=False)
class Body:
    """One rigid hull of the robot.

    Attributes:
        name: its link's name.
        joint: index of the Pinocchio joint that carries it; 0 is the base.
        hull: in that joint's frame.
    """

    name: str
    joint: int
    hull: Part


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A robot's kinematics and hulls. Configurations are arm joints only, shape (dof,) [rad]; fingers have an opening.

    Attributes:
        spec: what the robot's folder says.
        model: Pinocchio's model in the world frame; its joints are the arm's and the fingers'.
        bodies: the hulls of all links.
        pairs: indices into `bodies` of those that can collide with each other.
        arm: indices of the arm's joints in Pinocchio's configuration, shape (dof,).
        fingers: indices of the gripper's joints in Pinocchio's configuration.
        linkage: how those go with the opening.
        tool_joint: index of the joint that carries the tool.
        T_joint_tool: tool frame in that joint's frame, shape (4, 4).
        hand: indices into `bodies` of hand and fingers: of the link that carries both tool and fingers, and all
            that it carries.
    """

    spec: RobotSpec
    model: Any
    bodies: tuple[Body, ...]
    pairs: tuple[tuple[int, int], ...]
    arm: NDArray[np.int64]
    fingers: NDArray[np.int64]
    linkage: Linkage
    tool_joint: int
    T_joint_tool: Matrix
    hand: tuple[int, ...]

    @property
    def dof(self) -> int:
        """Number of arm joints."""
        return len(self.spec.joints)

    @property
    def lower(self) -> Vector:
        """Lower position limits, shape (dof,) [rad]."""
        return np.array(self.spec.lower)

    @property
    def upper(self) -> Vector:
        """Upper position limits, shape (dof,) [rad]."""
        return np.array(self.spec.upper)

    @property
    def home(self) -> Vector:
        """Rest configuration, shape (dof,) [rad]."""
        return np.array(self.spec.home)

    def full(self, q: Vector, opening: float) -> Vector:
        """Pinocchio's configuration for arm joints `q` [rad] and a distance between the finger pads [m]."""
        complete = np.empty(self.model.nq)
        complete[self.arm] = q
        complete[self.fingers] = self.linkage.joints(opening)
        return complete

    def forward(self, q: Vector) -> Matrix:
        """`T_world_tool`, shape (4, 4), at a configuration."""
        data = self.model.createData()
        pin.forwardKinematics(self.model, data, self.full(q, 0.0))
        T: Matrix = data.oMi[self.tool_joint].homogeneous @ self.T_joint_tool
        return T

    def joint_poses(self, states: Matrix, opening: float) -> Matrix:
        """Joint frames in the world, by Pinocchio's index, at configurations (n, dof); shape (n, joints, 4, 4)."""
        data = self.model.createData()
        full = self.full(self.home, opening)
        poses = np.empty((len(states), self.model.njoints, 4, 4))
        for i, q in enumerate(states):
            full[self.arm] = q
            pin.forwardKinematics(self.model, data, full)
            poses[i] = [T.homogeneous for T in data.oMi]
        return poses

    def within_limits(self, q: Vector, slack: float = 1e-9) -> bool:
        """Whether every joint is inside its position limits."""
        return bool((q >= self.lower - slack).all() and (q <= self.upper + slack).all())

    def overshot(self, q: Vector) -> Vector:
        """Where an arm is taken to stand: at a joint's limit where its motor came to rest a hair beyond it [rad]."""
        near = np.clip(q, self.lower, self.upper)
        return np.where(np.abs(q - near) < OVERSHOT, near, q)


@cache
def robot_model(spec: RobotSpec) -> RobotModel:
    """The model of a robot.

    Raises:
        RobotError: where its URDF is missing or malformed, or refers to a mesh that is; says which.
    """
    shapes = link_shapes(spec)
    model = _pinocchio_model(spec)
    bodies = tuple(_body(model, shape.link, shape.hull) for shape in shapes)
    frame = model.frames[model.getBodyId(spec.tool_parent)]
    names = carried(spec.description, (spec.tool_parent, *spec.gripper.fingers))
    arm = np.array([model.joints[model.getJointId(name)].idx_q for name in spec.joints])
    fingers = np.array([model.joints[model.getJointId(name)].idx_q for name in spec.gripper.joints])
    robot = RobotModel(
        spec=spec,
        model=model,
        bodies=bodies,
        pairs=(),
        arm=arm,
        fingers=fingers,
        linkage=linkage(spec),
        tool_joint=frame.parentJoint,
        T_joint_tool=frame.placement.homogeneous @ spec.T_parent_tool.matrix,
        hand=tuple(i for i, body in enumerate(bodies) if body.name in names),
    )
    return replace(robot, pairs=self_collision_pairs(robot))


def _pinocchio_model(spec: RobotSpec) -> Any:
    """The description's model, moved to where the base stands."""
    model = pin.buildModelFromXML(without_shapes(spec.description))
    T_world_base = pin.SE3(spec.T_world_base.matrix)
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = T_world_base * model.jointPlacements[joint]
    for frame in model.frames:
        if frame.parentJoint == 0:
            frame.placement = T_world_base * frame.placement
    return model


def _body(model: Any, link: str, hull: Part) -> Body:
    frame = model.frames[model.getBodyId(link)]
    points = hull.vertices @ frame.placement.rotation.T + frame.placement.translation
    return Body(link, int(frame.parentJoint), Part(points, hull.faces))
