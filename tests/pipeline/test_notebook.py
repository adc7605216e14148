"""The public way in: a workspace and a context with which samplers and the world are called by hand."""

from pathlib import Path

import numpy as np
import pytest

import tamp
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.motion.paths import plan_free_motion
from tamp.streams.values import Configuration
from tamp.world.kinematics.inverse import inverse
from tamp.world.motion.planner import plan_motion
from tamp.world.scene import Scene

SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.fixture(scope="module")
def workspace():
    return tamp.prepare(tamp.load_task(SCENARIOS / "one_object.yaml"))


def test_everything_stands_where_it_has_settled(workspace):
    assert set(workspace.start) == {"red"}
    assert workspace.start["red"].on == ("table",)
    assert set(workspace.goals) == {"red"}


def test_a_sampler_is_called_and_its_grasp_reached_from_home(workspace):
    grasp = next(sample_grasp(tamp.sampler_context(workspace), "red"))
    before, after, handling = next(
        inverse_kinematics(tamp.sampler_context(workspace), "red", workspace.start["red"], grasp)
    )
    assert handling.object == "red"
    assert before.opening > after.opening == grasp.width
    spec = workspace.world.robot.spec
    home = Configuration(tuple(spec.home), spec.gripper.stroke)
    path = next(plan_free_motion(tamp.sampler_context(workspace), home, before))
    assert np.allclose(path.points[0], home.q)
    assert np.allclose(path.points[-1], before.q)


def test_the_same_seed_draws_the_same(workspace):
    draws = [next(sample_grasp(tamp.sampler_context(workspace, seed=seed), "red")) for seed in (3, 3)]
    assert draws[0] == draws[1]


def test_the_world_answers_without_a_sampler(workspace):
    robot, rng = workspace.world.robot, np.random.default_rng(0)
    checker = workspace.world.checker(Scene({"red": workspace.start["red"].pose.matrix}))
    T = tamp.Pose.from_rpy((0.0, -0.2, 0.3), (np.pi, 0.0, 0.0)).matrix
    q = next(inverse(robot, T, rng, checker=checker))
    assert np.allclose(robot.forward(q), T, atol=1e-4)
    limits, home = (np.array(robot.spec.lower), np.array(robot.spec.upper)), np.array(robot.spec.home)
    assert plan_motion(checker, *limits, home, q, seed=0, timeout=10.0).path is not None
