"""Which links of a robot can collide with each other: found by sampling configurations, cached by content."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from tamp.task.cache import cached, content_key
from tamp.world.solid import solid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.robot_model import RobotModel

SAMPLES = 5000
NEAR = 0.03
"""Two links that never come closer than this [m] in all samples are taken never to collide."""


def self_collision_pairs(robot: RobotModel) -> tuple[tuple[int, int], ...]:
    """Pairs of bodies (i < j) that can collide: not neighbours, not overlapping by construction, not always apart."""
    content = b"".join(body.hull.vertices.tobytes() + bytes([body.joint]) for body in robot.bodies)
    key = content_key("self-pairs-2", robot.spec.urdf.read_bytes(), content, repr(robot.spec))
    stored = cached("self-collision", key, lambda: {"pairs": _sample_pairs(robot)})
    return tuple((int(a), int(b)) for a, b in stored["pairs"])


def _sample_pairs(robot: RobotModel) -> NDArray[np.int64]:
    fingers = set(robot.spec.gripper.fingers)
    geometry = pin.GeometryModel()
    for i, body in enumerate(robot.bodies):
        geometry.addGeometryObject(pin.GeometryObject(str(i), body.joint, pin.SE3.Identity(), solid([body.hull]).hull))
    candidates = [
        (i, j)
        for j in range(len(robot.bodies))
        for i in range(j)
        if robot.bodies[i].joint not in (robot.model.parents[robot.bodies[j].joint], robot.bodies[j].joint)
        and not {robot.bodies[i].name, robot.bodies[j].name} <= fingers
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
    close, hits = np.zeros(len(candidates), dtype=int), np.zeros(len(candidates), dtype=int)
    for _ in range(SAMPLES):
        q = robot.full(rng.uniform(robot.lower, robot.upper), rng.uniform(0.0, robot.spec.gripper.stroke))
        pin.computeCollisions(robot.model, data, geometry, near, q, False)
        close += [result.isCollision() for result in near.collisionResults]
        pin.computeCollisions(robot.model, data, geometry, touching, q, False)
        hits += [result.isCollision() for result in touching.collisionResults]
    q = robot.full(robot.home, robot.spec.gripper.stroke)
    pin.computeCollisions(robot.model, data, geometry, touching, q, False)
    built_in = np.array([result.isCollision() for result in touching.collisionResults])
    return [pair for k, pair in enumerate(candidates) if close[k] and hits[k] < 0.95 * SAMPLES and not built_in[k]]
