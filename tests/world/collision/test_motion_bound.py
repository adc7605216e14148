from __future__ import annotations

import numpy as np
import pinocchio as pin

from tamp.task import Box
from tamp.world.collision.motion_bound import travel
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.scene import Scene
from tamp.world.world import World


def corners(robot, q, opening):
    """All vertices of all hulls in the world frame, shape (n, 3)."""
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full(q, opening))
    placed = ((data.oMi[body.joint], body.hull.vertices) for body in robot.bodies)
    return np.concatenate([points @ T.rotation.T + T.translation for T, points in placed])


def test_no_point_moves_farther_than_the_bound_and_the_bound_is_near(panda):
    rng = np.random.default_rng(0)
    shares = []
    for _ in range(300):
        q = rng.uniform(panda.lower, panda.upper)
        step = rng.normal(0.0, 0.01, panda.dof) * (rng.random(panda.dof) < 0.5)
        moved = np.linalg.norm(corners(panda, q + step, 0.08) - corners(panda, q, 0.08), axis=1).max()
        bound = travel(panda, np.array([q, q + step]), 0.0)[0]
        assert moved <= bound + 1e-12
        shares += [moved / bound] if step.any() else []
    assert np.mean(shares) > 0.7


def test_what_is_held_moves_farther(panda):
    world = World(panda, {"pole": load_geometry(Box((0.02, 0.02, 1.0)))})
    turn = np.array([world.robot.home, world.robot.home + 0.1 * np.eye(7)[6]])
    empty = world.checker(Scene()).travel(turn)[0]
    holding = world.checker(Scene().attached("pole", np.eye(4), 0.02)).travel(turn)[0]
    assert empty < 0.03 and holding > 0.05
