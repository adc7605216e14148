import numpy as np
import pytest

from tamp.task import Box, Pose, load_robot
from tamp.world.geometry import load_geometry
from tamp.world.motion_cache import MotionCache
from tamp.world.robot_model import robot_model
from tamp.world.scene import Scene
from tamp.world.world import World


@pytest.fixture(scope="module")
def world() -> World:
    return World(robot_model(load_robot("panda")), {"post": load_geometry(Box((0.05, 0.05, 0.9)))})


def checker_of(world, x, margin=0.002):
    return world.checker(Scene(poses={"post": Pose((x, 0.0, 0.45)).matrix}), margin=margin)


def ends(world):
    start, goal = world.robot.home.copy(), world.robot.home.copy()
    start[0], goal[0] = -0.9, 0.9
    return start, goal


def test_the_same_question_is_answered_once(world):
    cache = MotionCache()
    first = cache.plan(checker_of(world, 0.15), *ends(world), seed=0, timeout=5.0)
    again = cache.plan(checker_of(world, 0.15), *ends(world), seed=0, timeout=9.0)
    assert again is first
    assert cache.hits == 1
    assert first.path is not None


@pytest.mark.parametrize("change", [{"x": 0.16}, {"margin": 0.004}, {"seed": 1}, {"shortcuts": 5}])
def test_whatever_could_change_the_answer_makes_another_question(world, change):
    cache = MotionCache()
    cache.plan(checker_of(world, 0.15), *ends(world), seed=0, timeout=5.0)
    checker = checker_of(world, change.pop("x", 0.15), change.pop("margin", 0.002))
    cache.plan(checker, *ends(world), **{"seed": 0, "timeout": 5.0, **change})
    assert cache.hits == 0


def test_an_answer_that_the_clock_cut_short_is_not_kept(world):
    cache = MotionCache()
    assert cache.plan(checker_of(world, 0.15), *ends(world), seed=0, timeout=0.0).path is None
    assert cache.plan(checker_of(world, 0.15), *ends(world), seed=0, timeout=5.0).path is not None


def test_the_oldest_answers_are_forgotten(world):
    cache = MotionCache(capacity=1)
    start, goal = ends(world)
    for q in (goal, start, goal):
        cache.plan(checker_of(world, 0.6), world.robot.home, np.array(q), seed=0, timeout=5.0)
    assert cache.hits == 0
