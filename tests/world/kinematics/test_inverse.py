from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.task import Box, load_robot
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.kinematics.inverse import inverse, reachable, straight_line
from tamp.world.kinematics.levenberg_marquardt import rotation_vector
from tamp.world.robot.model import robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

PANDA = robot_model(load_robot("panda"))


def tool_at(x, y, z):
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = x, y, z
    return T


def angle_between(A, B):
    return float(np.linalg.norm(rotation_vector((A[:3, :3].T @ B[:3, :3])[None])[0]))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_every_solution_is_exact_within_limits_and_different(seed):
    rng = np.random.default_rng(seed)
    T = PANDA.forward(rng.uniform(PANDA.lower, PANDA.upper))
    solutions = list(inverse(PANDA, T, rng))
    assert solutions, "a reachable pose was not reached"
    for k, q in enumerate(solutions):
        reached = PANDA.forward(q)
        assert np.linalg.norm(reached[:3, 3] - T[:3, 3]) < 1e-5
        assert angle_between(reached, T) < 1e-4
        assert PANDA.within_limits(q, slack=0.0)
        assert all(np.abs(q - other).max() >= 0.05 for other in solutions[:k])


def test_the_same_generator_repeats_the_same_solutions():
    T = tool_at(0.1, 0.2, 0.1)
    first, second = (list(inverse(PANDA, T, np.random.default_rng(4))) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert len(first) == 8


def test_nothing_is_found_out_of_reach():
    assert list(inverse(PANDA, tool_at(3, 0, 0.1), np.random.default_rng(0))) == []
    assert list(inverse(PANDA, tool_at(0.47, 0, 0.1), np.random.default_rng(0))) == []


def test_near_comes_first():
    T = PANDA.forward(PANDA.home)
    solutions = list(inverse(PANDA, T, np.random.default_rng(0), near=PANDA.home))
    np.testing.assert_allclose(solutions[0], PANDA.home, atol=1e-5)
    assert len(solutions) == 8


def test_only_free_configurations_leave_where_a_checker_is_given():
    T_box = np.eye(4)
    T_box[:3, 3] = -0.1, 0.25, 0.3
    world = World(PANDA, {"wall": load_geometry(Box((0.04, 0.04, 0.6)))})
    checker = world.checker(Scene({"wall": T_box}, opening=0.08))
    T = tool_at(0.1, 0.1, 0.1)
    every = list(inverse(PANDA, T, np.random.default_rng(0), count=16))
    free = list(inverse(PANDA, T, np.random.default_rng(0), count=16, checker=checker))
    assert free
    assert all(checker.free(q) for q in free)
    assert not all(checker.free(q) for q in every)


def test_a_straight_line_is_straight_and_continuous():
    rng = np.random.default_rng(0)
    drawn = 0
    for _ in range(20):
        T = tool_at(*rng.uniform([-0.05, -0.3, 0.05], [0.2, 0.3, 0.2]))
        goal = T.copy()
        goal[:3, 3] += (0.03, 0.0, 0.1)
        for q in inverse(PANDA, T, rng, count=2):
            path = straight_line(PANDA, q, goal)
            if path is None:
                continue
            drawn += 1
            np.testing.assert_array_equal(path[0], q)
            start, end = PANDA.forward(q), PANDA.forward(path[-1])
            np.testing.assert_allclose(end, goal, atol=1e-4)
            along = (goal[:3, 3] - start[:3, 3]) / np.linalg.norm(goal[:3, 3] - start[:3, 3])
            tips = np.array([PANDA.forward(p)[:3, 3] for p in path]) - start[:3, 3]
            assert np.linalg.norm(tips - np.outer(tips @ along, along), axis=1).max() < 1e-5
            assert (np.diff(tips @ along) > 0).all()
            assert np.diff(tips @ along).max() < 0.0101
            assert np.abs(np.diff(path, axis=0)).max() < 0.3
            assert all(PANDA.within_limits(p) for p in path)
    assert drawn > 30


def test_a_straight_line_out_of_reach_is_none():
    q = next(inverse(PANDA, tool_at(0.1, 0, 0.1), np.random.default_rng(0)))
    assert straight_line(PANDA, q, tool_at(1.5, 0, 0.1)) is None


@settings(max_examples=50, deadline=None)
@given(st.tuples(*3 * [st.floats(-1, 1)]), st.floats(0.0, np.pi))
def test_a_rotation_vector_rebuilds_its_rotation(direction, angle):
    length = np.linalg.norm(direction)
    if length < 1e-3:
        return
    a = np.array(direction) / length
    skew = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    R = np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew
    vector = rotation_vector(R[None])[0]
    assert np.linalg.norm(vector) == pytest.approx(angle, abs=1e-6)
    if 1e-6 < angle < 3.1:
        np.testing.assert_allclose(vector, angle * a, atol=1e-6)


def test_a_glance_at_many_poses_finds_most_that_are_in_reach_and_none_that_is_not():
    rng = np.random.default_rng(0)
    inside = np.array([PANDA.forward(rng.uniform(PANDA.lower, PANDA.upper)) for _ in range(200)])
    beyond = inside.copy()
    beyond[:, :3, 3] += [2.0, 0.0, 0.0]
    found = reachable(PANDA, np.concatenate([inside, beyond]))
    assert found[:200].mean() > 0.8
    assert not found[200:].any()
    assert reachable(PANDA, np.empty((0, 4, 4))).shape == (0,)
