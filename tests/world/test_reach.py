import numpy as np
import pinocchio as pin
import pytest

from tamp.task import Box
from tamp.world.geometry import load_geometry
from tamp.world.reach import reach_of
from tamp.world.scene import Scene
from tamp.world.world import World


def corners(robot, q, opening):
    """All vertices of all hulls in the world frame, shape (n, 3)."""
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full(q, opening))
    placed = ((data.oMi[body.joint], body.hull.vertices) for body in robot.bodies)
    return np.concatenate([points @ T.rotation.T + T.translation for T, points in placed])


def test_no_point_moves_farther_than_the_levers_allow(panda):
    rng = np.random.default_rng(0)
    levers = reach_of(panda).levers(0.0)
    for _ in range(300):
        q = rng.uniform(panda.lower, panda.upper)
        step = rng.normal(0.0, 0.01, panda.dof) * (rng.random(panda.dof) < 0.5)
        moved = np.linalg.norm(corners(panda, q + step, 0.08) - corners(panda, q, 0.08), axis=1)
        assert moved.max() <= np.abs(step) @ levers + 1e-12


def test_the_levers_are_not_much_longer_than_the_arm(panda):
    levers = reach_of(panda).levers(0.0)
    assert levers[0] == pytest.approx(1.14, abs=0.02) and levers[-1] == pytest.approx(0.26, abs=0.02)
    assert (np.diff(levers) <= 0).all()


def test_what_is_held_lengthens_the_levers(panda):
    world = World(panda, {"pole": load_geometry(Box((0.02, 0.02, 1.0)))})
    empty = world.checker(Scene()).levers
    holding = world.checker(Scene().attached("pole", np.eye(4), 0.02)).levers
    assert (holding > empty).all() and holding[-1] > 0.5
