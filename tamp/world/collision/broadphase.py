"""Pinocchio's broadphase over a set of bodies: who moves in it, and what is met where things stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from tamp.world.geometry import convex_union
from tamp.world.geometry.convex_union import Solid, solid
from tamp.world.robot.model import RobotModel

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
    joints = sorted(robot.model.getJointId(name) for name in robot.spec.gripper.joints)
    for joint in joints:  # those that carry others come first
        parent, placement = joint_of[robot.model.parents[joint]], robot.model.jointPlacements[joint]
        joint_of[joint] = model.addJoint(parent, robot.model.joints[joint], placement, robot.model.names[joint])
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


def hand_configuration(robot: RobotModel, T_world_tool: Matrix, opening: float) -> Vector:
    """The free hand's configuration with its tool at `T_world_tool` and the pads `opening` [m] apart."""
    T_world_joint = pin.SE3(T_world_tool) * pin.SE3(robot.T_joint_tool).inverse()
    fingers = robot.linkage.joints(opening)[np.argsort(robot.fingers)]
    return np.concatenate([pin.SE3ToXYZQUAT(T_world_joint), fingers])


SELF_MARGIN = 0.002
"""Clearance kept between the robot's own links [m]: hulls are exact here, and joints know where they are."""


@dataclass(frozen=True, eq=False)
class Setting:
    """Where things stand and how close they may come, for one arena.

    Attributes:
        poses: object -> `T_world_object`; objects of the arena that are absent here are out of the way.
        T_tool_held: where the held object lies in the tool frame; of no meaning where nothing is held.
        margin: least distance of the actor's bodies to everything [m].
        held_margin: least distance of the held object to everything [m]; negative tolerates penetration.
        touch: object (or "table") -> least distance of the actor's bodies to it, instead of `margin` [m].
        held_touch: the same of the held object, instead of `held_margin`.
    """

    poses: Mapping[str, Matrix]
    T_tool_held: Matrix
    margin: float
    held_margin: float
    touch: Mapping[str, float]
    held_touch: Mapping[str, float] = field(default_factory=dict)


class Arena:
    """The actor, the table, all objects and, attached to the tool, the held one."""

    def __init__(
        self, actor: Actor, table: tuple[Solid, Matrix], objects: Mapping[str, Solid], held: str | None
    ) -> None:
        self.actor = actor
        self._standing = tuple(sorted(set(objects) - {held}))
        self._table_index = len(actor.solids)
        self._object_index = {name: self._table_index + 1 + i for i, name in enumerate(self._standing)}
        self._held_index = self._table_index + 1 + len(self._standing) if held is not None else None
        self.names: tuple[str, ...] = (*actor.names, "table", *self._standing, *(() if held is None else (held,)))
        self._solids = (*actor.solids, table[0], *(objects[n] for n in self._standing))
        if held is not None:
            self._solids = (*self._solids, objects[held])
        self._geometry = pin.GeometryModel()
        joints = (*actor.joints, *(0 for _ in range(1 + len(self._standing))), actor.tool_joint)
        for i, shape in enumerate(self._solids):
            placement = pin.SE3(table[1]) if i == self._table_index else pin.SE3.Identity()
            self._geometry.addGeometryObject(pin.GeometryObject(str(i), joints[i], placement, shape.hull))
        self.pairs = tuple(self._collision_pairs())
        for a, b in self.pairs:
            self._geometry.addCollisionPair(pin.CollisionPair(a, b))
        self._rough = tuple(not (self._solids[a].convex and self._solids[b].convex) for a, b in self.pairs)
        self._objects = list(self._geometry.geometryObjects)
        self._data = actor.model.createData()
        self._geometry_data = self._geometry.createData()
        self._broadphase = pin.BroadPhaseManager_NaiveCollisionManager(actor.model, self._geometry, self._geometry_data)
        self._callback = pin.CollisionCallBackDefault(self._geometry, self._geometry_data, True)
        self._margins = np.zeros((len(self._solids), len(self._solids)))
        self._setting: Setting | None = None
        self._placed: dict[str, Matrix] = {}
        for name in self._standing:
            self._remove(name)

    def _collision_pairs(self) -> Iterator[tuple[int, int]]:
        yield from self.actor.pairs
        static = range(self._table_index, self._table_index + 1 + len(self._standing))
        for body, joint in enumerate(self.actor.joints):
            if joint > 0:  # what does not move stands where it stands
                yield from ((body, other) for other in static)
        if self._held_index is not None:
            yield from ((other, self._held_index) for other in static)
            for body, joint in enumerate(self.actor.joints):
                if body not in self.actor.grip and joint != self.actor.tool_joint:
                    yield body, self._held_index

    def install(self, setting: Setting) -> None:
        """Let the next queries be about `setting`; costs next to nothing where it is installed already."""
        if setting is self._setting:
            return
        before = self._setting
        for name in self._standing:
            T = setting.poses.get(name)
            if T is self._placed.get(name):
                continue
            if T is None:
                self._remove(name)
            else:
                self._objects[self._object_index[name]].placement = pin.SE3(T)
                self._placed[name] = T
        if self._held_index is not None and (before is None or before.T_tool_held is not setting.T_tool_held):
            self._objects[self._held_index].placement = pin.SE3(self.actor.T_joint_tool @ setting.T_tool_held)
        if before is None or (before.margin, before.held_margin, before.touch, before.held_touch) != (
            setting.margin, setting.held_margin, setting.touch, setting.held_touch
        ):  # fmt: skip
            self._set_margins(setting)
        self._setting = setting

    def _remove(self, name: str) -> None:
        """Put an object where nothing reaches it."""
        index = self._object_index[name]
        self._objects[index].placement = pin.SE3(np.eye(3), np.array([0.0, 0.0, -100.0 - index]))
        self._placed.pop(name, None)

    def _set_margins(self, setting: Setting) -> None:
        bodies = len(self.actor.solids)
        self._margins[:] = setting.margin
        self._margins[:bodies, :bodies] = min(SELF_MARGIN, setting.margin)
        for name, margin in setting.touch.items():
            self._margins[:bodies, self._bodies_called(name)] = margin
        if self._held_index is not None:
            self._margins[:, self._held_index] = setting.held_margin
            for name, margin in setting.held_touch.items():
                self._margins[self._bodies_called(name), self._held_index] = margin
            self._margins[:bodies, self._held_index] = min(SELF_MARGIN, setting.margin)
        self._geometry_data.setSecurityMargins(self._geometry, self._margins, True, True)
        # The manager inflates boxes by the margins it sees here; without this call it keeps the old ones.
        self._broadphase.update(self._geometry_data)

    def _bodies_called(self, name: str) -> list[int]:
        """The index of an object or of the table; none where it is not in the arena."""
        index = self._table_index if name == "table" else self._object_index.get(name)
        return [] if index is None else [index]

    def held_radius(self, setting: Setting) -> float:
        """From the tool's joint to the farthest corner of a box round what is held [m]; 0 where nothing is."""
        if self._held_index is None:
            return 0.0
        held, T = self._solids[self._held_index], self.actor.T_joint_tool @ setting.T_tool_held
        center = np.linalg.norm(held.center @ T[:3, :3].T + T[:3, 3], axis=1)
        return float((center + np.linalg.norm(held.half, axis=1)).max())

    def hit(self, q: Vector) -> int | None:
        """Index of a pair of bodies that come too close at Pinocchio's configuration `q`, or None."""
        if not pin.computeCollisions(self.actor.model, self._data, self._broadphase, self._callback, q):
            return None
        pair: int = self._callback.collisionPairIndex
        return self._refined(pair) if self._rough[pair] else pair

    def _refined(self, pair: int) -> int | None:
        """Ask the parts where a hull was hit, then go on to the next pair; None where no parts touch."""
        dismissed = []
        found: int | None = pair
        while found is not None and self._rough[found] and not self._parts_overlap(found):
            self._geometry_data.deactivateCollisionPair(found)
            dismissed.append(found)
            more = pin.computeCollisions(self._broadphase, self._callback)
            found = self._callback.collisionPairIndex if more else None
        for index in dismissed:
            self._geometry_data.activateCollisionPair(index)
        return found

    def _parts_overlap(self, pair: int) -> bool:
        a, b = self.pairs[pair]
        return convex_union.overlap(self._solids[a], self._solids[b], self._relative(a, b), float(self._margins[a, b]))

    def _relative(self, a: int, b: int) -> Matrix:
        T_a_b: Matrix = self._geometry_data.oMg[a].actInv(self._geometry_data.oMg[b]).homogeneous
        return T_a_b

    def separation(self, pair: int) -> float:
        """Signed distance of a pair of bodies at the configuration last asked about [m]."""
        a, b = self.pairs[pair]
        return convex_union.separation(self._solids[a], self._solids[b], self._relative(a, b))

    def nearest(self, q: Vector) -> tuple[int, float]:
        """The pair of bodies with the smallest signed distance at `q`, and that distance [m]."""
        pin.computeDistances(self.actor.model, self._data, self._geometry, self._geometry_data, q)
        distances = [result.min_distance for result in self._geometry_data.distanceResults]
        best, nearest = -1, np.inf
        for pair in np.argsort(distances, kind="stable"):
            if distances[pair] >= nearest:
                break
            exact = self.separation(int(pair)) if self._rough[pair] else distances[pair]
            if exact < nearest:
                best, nearest = int(pair), float(exact)
        return best, nearest
