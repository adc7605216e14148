"""Collision queries: the Panda with a held box among convex obstacles, against python-fcl and PyBullet in one run.

Speed: microseconds a configuration, free or not, for 10 and 30 obstacles on the table.
Exactness: random configurations judged by python-fcl; a miss is a configuration called free in which some pair of
bodies penetrates by over 1 mm, a false hit one called in collision although every distance exceeds the margin.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from benchmarks.parts.harness import Row, main, percentile
from tamp.task import Box, Table, load_robot
from tamp.task.mesh.parts import Part, parts
from tamp.world.collision.checker import CollisionChecker
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.robot.model import RobotModel, robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

Array = NDArray[np.float64]

OBSTACLE = (0.06, 0.06, 0.16)
HELD = (0.05, 0.05, 0.08)
MARGIN = 0.002
MISS = 0.001


def run(quick: bool) -> Iterator[Row]:
    robot = robot_model(load_robot("panda"))
    for count in (10, 30):
        scene, world = _scene(robot, count)
        rng = np.random.default_rng(count)
        configurations = _configurations(robot, rng, 2000 if quick else 20000)
        few = configurations[: len(configurations) // 4]
        checker = world.checker(scene, margin=MARGIN)
        reference = FclReference(robot, world, scene)
        bullet = BulletReference(robot, scene)
        for name, query, states in (
            ("tamp (pinocchio)", checker.free, configurations),
            ("python-fcl", reference.free, few),
            ("pybullet", bullet.free, few),
        ):
            yield {"obstacles": count, "checker": name, **_timed(query, states)}
        bullet.close()
        yield {
            "obstacles": count,
            "checker": "tamp judged by python-fcl",
            **_judged(checker, reference, _configurations(robot, rng, 2000 if quick else 50000)),
        }


def _timed(query: Callable[[Array], bool], configurations: Array) -> Row:
    """Mean time of a query [us]: median and best of twenty batches, so that other work on the machine shows."""
    means, free = [], 0
    for batch in np.array_split(configurations, 20):
        start = time.perf_counter()
        free += sum([query(q) for q in batch])
        means.append((time.perf_counter() - start) / len(batch) * 1e6)
    return {"us": percentile(means, 50), "best_us": min(means), "free": free / len(configurations)}


def _judged(checker: CollisionChecker, reference: FclReference, configurations: Array) -> Row:
    missed = false_hits = 0
    deepest = 0.0
    for q in configurations:
        if checker.free(q):
            depth = reference.depth(q)
            missed += depth > MISS
            deepest = max(deepest, depth)
        else:
            false_hits += reference.distance(q) > MARGIN + 1e-5
    return {"queries": len(configurations), "missed": missed, "deepest_mm": deepest * 1e3, "false_hits": false_hits}


def _scene(robot: RobotModel, count: int) -> tuple[Scene, World]:
    """Boxes on the table clear of the robot's base, and one in the hand."""
    rng = np.random.default_rng(0)
    poses = {}
    for i in range(count):
        T = np.eye(4)
        turn = rng.uniform(-np.pi, np.pi)
        T[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        T[:3, 3] = (*rng.uniform([-0.15, -0.5], [0.3, 0.5]), OBSTACLE[2] / 2)
        poses[f"box{i}"] = T
    geometries = {name: load_geometry(Box(OBSTACLE)) for name in poses}
    geometries["held"] = load_geometry(Box(HELD))
    return Scene(poses).attached("held", np.eye(4), HELD[1]), World(robot, geometries, Table())


def _configurations(robot: RobotModel, rng: np.random.Generator, count: int) -> Array:
    """Half uniform, half around the reaching posture that a planner at a table mostly asks about."""
    half = count // 2
    uniform = rng.uniform(robot.lower, robot.upper, (half, robot.dof))
    reaching = np.clip(robot.home + rng.normal(0.0, 0.5, (count - half, robot.dof)), robot.lower, robot.upper)
    mixed = np.concatenate([uniform, reaching])
    rng.shuffle(mixed)
    return mixed


class FclReference:
    """The same question put to python-fcl, pair by pair, with its own shapes and its own broadphase."""

    def __init__(self, robot: RobotModel, world: World, scene: Scene) -> None:
        import fcl

        self._fcl, self._robot = fcl, robot
        self._data = robot.model.createData()
        self._full = robot.full(robot.home, scene.opening)
        self._links = [fcl.CollisionObject(_fcl_convex(body.hull)) for body in robot.bodies]
        held, T_tool_held = scene.held or ("", np.eye(4))
        self._held = fcl.CollisionObject(_fcl_convex(world.geometries[held].parts[0]))
        self._T_joint_held = robot.T_joint_tool @ T_tool_held
        fixed = [fcl.CollisionObject(_fcl_convex(_table_part(world.table)))]
        for name, T in scene.poses.items():
            fixed.append(
                fcl.CollisionObject(
                    _fcl_convex(world.geometries[name].parts[0]), fcl.Transform(np.array(T[:3, :3]), np.array(T[:3, 3]))
                )
            )
        self._obstacles = _managed(fcl, fixed)
        moving = [shape for shape, body in zip(self._links, robot.bodies, strict=True) if body.joint > 0]
        self._moving = _managed(fcl, [*moving, self._held])
        self._pairs = [(self._links[a], self._links[b]) for a, b in robot.pairs] + [
            (self._links[i], self._held)
            for i, body in enumerate(robot.bodies)
            if i not in robot.hand and body.joint != robot.tool_joint
        ]

    def _place(self, q: Array) -> None:
        self._full[self._robot.arm] = q
        pin.forwardKinematics(self._robot.model, self._data, self._full)
        for shape, body in zip(self._links, self._robot.bodies, strict=True):
            T = self._data.oMi[body.joint]
            shape.setTransform(self._fcl.Transform(T.rotation, T.translation))
        T_held = self._data.oMi[self._robot.tool_joint].homogeneous @ self._T_joint_held
        self._held.setTransform(self._fcl.Transform(T_held[:3, :3], T_held[:3, 3]))
        self._moving.update()

    def free(self, q: Array) -> bool:
        """Whether no pair of bodies overlaps."""
        self._place(q)
        found = self._fcl.CollisionData()
        self._moving.collide(self._obstacles, found, self._fcl.defaultCollisionCallback)
        if found.result.is_collision:
            return False
        return not any(
            self._fcl.collide(a, b, self._fcl.CollisionRequest(), self._fcl.CollisionResult()) for a, b in self._pairs
        )

    def depth(self, q: Array) -> float:
        """The deepest penetration of any pair of bodies [m]; 0 where none overlaps."""
        self._place(q)
        request = self._fcl.CollisionRequest(num_max_contacts=1000, enable_contact=True)
        found = self._fcl.CollisionData(request=request)
        self._moving.collide(self._obstacles, found, self._fcl.defaultCollisionCallback)
        contacts = list(found.result.contacts)
        for a, b in self._pairs:
            result = self._fcl.CollisionResult()
            self._fcl.collide(a, b, request, result)
            contacts += result.contacts
        return max((contact.penetration_depth for contact in contacts), default=0.0)

    def distance(self, q: Array) -> float:
        """The smallest distance of any pair of bodies [m]; not above 0 where some overlap."""
        self._place(q)
        found = self._fcl.DistanceData()
        self._moving.distance(self._obstacles, found, self._fcl.defaultDistanceCallback)
        nearest = found.result.min_distance
        for a, b in self._pairs:
            nearest = min(nearest, self._fcl.distance(a, b, self._fcl.DistanceRequest(), self._fcl.DistanceResult()))
        return float(nearest)


def _managed(fcl: object, shapes: Sequence[object]) -> object:
    manager = fcl.DynamicAABBTreeCollisionManager()
    manager.registerObjects(list(shapes))
    manager.setup()
    return manager


def _fcl_convex(part: Part) -> object:
    import fcl

    faces = np.concatenate([np.full((len(part.faces), 1), 3), part.faces], axis=1).flatten()
    return fcl.Convex(part.vertices, len(part.faces), faces)


def _table_part(table: Table) -> Part:
    part = parts(Box((*table.size, table.thickness)))[0]
    return Part(part.vertices + np.array([*table.center, -table.thickness / 2]), part.faces)


class BulletReference:
    """The same scene in PyBullet: move the joints, then ask for all contacts of the robot and the held box."""

    def __init__(self, robot: RobotModel, scene: Scene) -> None:
        import pybullet
        from pybullet_utils import bullet_client

        spec = robot.spec
        self._bullet = bullet_client.BulletClient(pybullet.DIRECT)
        flags = pybullet.URDF_USE_SELF_COLLISION | pybullet.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT
        pose = spec.T_world_base
        self._body = self._bullet.loadURDF(str(spec.urdf), pose.xyz, pose.quat, useFixedBase=True, flags=flags)
        count = self._bullet.getNumJoints(self._body)
        joints = {self._bullet.getJointInfo(self._body, i)[1].decode(): i for i in range(count)}
        links = {self._bullet.getJointInfo(self._body, i)[12].decode(): i for i in range(count)}
        self._arm = [joints[name] for name in spec.joints]
        self._tool = links[spec.tool_parent]
        for finger in spec.gripper.joints:
            self._bullet.resetJointState(self._body, joints[finger], scene.opening / 2)
        self._offset = spec.T_parent_tool.xyz
        box = self._bullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[v / 2 for v in OBSTACLE])
        for T in scene.poses.values():
            yaw = float(np.arctan2(T[1, 0], T[0, 0]))
            turn = self._bullet.getQuaternionFromEuler([0, 0, yaw])
            self._bullet.createMultiBody(0, box, -1, T[:3, 3].tolist(), turn)
        top = Table()
        size = [top.size[0] / 2, top.size[1] / 2, top.thickness / 2]
        slab = self._bullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=size)
        table = self._bullet.createMultiBody(0, slab, -1, [*top.center, -top.thickness / 2])
        held = self._bullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[v / 2 for v in HELD])
        self._held = self._bullet.createMultiBody(1.0, held)
        links[robot.bodies[0].name] = -1
        for body in robot.bodies:
            if body.joint == 0:
                self._bullet.setCollisionFilterPair(self._body, table, links[body.name], -1, 0)
            if body.joint >= robot.tool_joint:
                self._bullet.setCollisionFilterPair(self._body, self._held, links[body.name], -1, 0)
        for j, b in enumerate(robot.bodies):
            for i, a in enumerate(robot.bodies[:j]):
                if (i, j) not in robot.pairs:
                    self._bullet.setCollisionFilterPair(self._body, self._body, links[a.name], links[b.name], 0)

    def free(self, q: Array) -> bool:
        """Whether neither robot nor held box has a contact."""
        for joint, value in zip(self._arm, q, strict=True):
            self._bullet.resetJointState(self._body, joint, value)
        state = self._bullet.getLinkState(self._body, self._tool, computeForwardKinematics=True)
        position, turn = self._bullet.multiplyTransforms(state[4], state[5], self._offset, [0, 0, 0, 1])
        self._bullet.resetBasePositionAndOrientation(self._held, position, turn)
        self._bullet.performCollisionDetection()
        return not self._bullet.getContactPoints(self._body) and not self._bullet.getContactPoints(self._held)

    def close(self) -> None:
        """Let the physics server go."""
        self._bullet.disconnect()


if __name__ == "__main__":
    main(
        "collision",
        lambda quick: list(run(quick)),
        asked="us of tamp at most 12 and 14 with 10 and 30 obstacles, missed 0",
    )
