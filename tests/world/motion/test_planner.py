from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from tamp.task import Box, Pose, load_robot
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.motion.paths import length
from tamp.world.motion.planner import MotionCache, _shortened, plan_motion, planner_names
from tamp.world.robot.model import robot_model
from tamp.world.scene import Scene
from tamp.world.timing.time_parametrization import time_free_path
from tamp.world.world import World

LOWER, UPPER = np.full(3, -2.0), np.full(3, 2.0)
LEFT, RIGHT = np.array([-1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Bump:
    a: str = "panda_link5"
    b: str = "wall"
    distance: float = -0.01

    def __str__(self):
        return f"{self.a} penetrates {self.b}"


class Doorway:
    """A wall across the first coordinate, with a gap above `sill` in the second; `sill` 2 leaves none."""

    def __init__(self, sill=1.5):
        self.sill, self.asked = sill, 0

    def free(self, q):
        self.asked += 1
        return not (abs(q[0]) < 0.3 and q[1] < self.sill)

    def edge_free(self, q0, q1, resolution=0.05):
        count = max(1, int(np.ceil(np.linalg.norm(q1 - q0) / resolution)))
        return all(self.free(q0 + k / count * (q1 - q0)) for k in range(count + 1))

    def contact(self, q):
        return None if self.free(q) else Bump()


def plan(checker, start=LEFT, goal=RIGHT, **options):
    return plan_motion(checker, LOWER, UPPER, start, goal, **{"seed": 0, "timeout": 10.0, **options})


def test_a_path_through_the_door_is_found_and_free():
    result = plan(Doorway())
    assert result.reason == "" and not result.exhausted
    assert (result.path[0] == LEFT).all() and (result.path[-1] == RIGHT).all()
    assert all(Doorway().edge_free(a, b, 0.02) for a, b in zip(result.path[:-1], result.path[1:], strict=True))


def test_the_straight_edge_is_taken_where_it_is_free():
    result = plan(Doorway(), goal=np.array([-1.0, 1.5, 0.0]))
    assert len(result.path) == 2


def test_the_same_seed_gives_the_same_path_within_one_process():
    paths = [plan(Doorway(), seed=seed).path for seed in (7, 8, 7)]
    assert (paths[0] == paths[2]).all()
    assert paths[0].shape != paths[1].shape or (paths[0] != paths[1]).any()


def test_shortcuts_shorten():
    assert length(plan(Doorway()).path) < length(plan(Doorway(), shortcuts=0).path) + 1e-9


def test_where_a_shortcut_grazes_something_other_shortcuts_are_taken():
    class SeenClosely(Doorway):
        def edge_free(self, q0, q1, resolution=0.05):
            return resolution > 0.03 or super().edge_free(q0, q1, resolution)

    corners = [(-1.0, 1.8), (-0.6, 1.9), (-1.0, 1.6), (-0.6, 1.8), (0.6, 1.7), (0.5, 1.9), (1.0, 1.6)]
    found = np.array([LEFT, *((x, y, 0.0) for x, y in corners), RIGHT])
    path = _shortened(SeenClosely(), found, 0, 20, 0.05, 0.02)
    assert all(Doorway().edge_free(a, b, 0.02) for a, b in pairwise(path))
    assert length(path) < 0.9 * length(found)


@pytest.mark.parametrize(("which", "ends"), [("start", (np.zeros(3), RIGHT)), ("goal", (LEFT, np.zeros(3)))])
def test_an_end_in_collision_is_refused_at_once_and_says_what_touches(which, ends):
    checker = Doorway()
    result = plan(checker, *ends)
    assert result.path is None and not result.exhausted
    assert result.reason == f"the {which} is in collision: panda_link5 penetrates wall"
    assert result.bodies == ("panda_link5", "wall")
    assert checker.asked <= 4


def test_an_end_beyond_the_limits_names_the_joint():
    result = plan(Doorway(), goal=np.array([1.0, 0.0, 2.5]))
    assert result.reason == "the goal has joint 3 at 2.5000, beyond its limits [-2.0000, 2.0000]"


def test_an_end_on_a_limit_up_to_rounding_is_an_end():
    start = np.array([-1.0, 0.0, LOWER[2] - 1e-10])
    assert (plan(Doorway(), start=start).path[0] == start).all()


def test_any_of_several_goals_will_do_and_blocked_ones_are_ignored():
    result = plan(Doorway(), goal=np.array([[0.0, 0.0, 0.0], [1.0, 1.9, 0.0], [-1.2, 0.1, 0.0]]))
    assert result.path[-1].tolist() == [-1.2, 0.1, 0.0]


def test_a_closed_door_ends_by_iterations_and_is_no_proof():
    result = plan(Doorway(sill=3.0), iterations=200)
    assert result.path is None and result.exhausted
    assert result.reason.startswith("no path found")


@pytest.mark.parametrize("planner", ["rrtconnect", "rrt", "kpiece", "bkpiece", "lbkpiece", "bfmt"])
def test_planners_by_name(planner):
    assert plan(Doorway(sill=0.5), planner=planner).path is not None


def test_optimising_planners_use_the_time_they_are_given():
    assert plan(Doorway(sill=0.5), planner="aorrtc", timeout=2.0).path is not None


def test_an_unknown_planner_is_answered_with_the_valid_names():
    with pytest.raises(
        ValueError,
        match=r"unknown motion planner 'rrtc'; did you mean 'rrt'. there are portfolio, rrtconnect, rrt, .*aorrtc",
    ):
        plan(Doorway(), planner="rrtc")
    assert planner_names()[:2] == ("portfolio", "rrtconnect")


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="differ in their joints"):
        plan(Doorway(), goal=np.zeros(4))


def test_a_bug_in_the_checker_comes_out_as_it_is():
    class Broken(Doorway):
        def edge_free(self, q0, q1, resolution=0.05):
            if self.asked > 100:
                raise ZeroDivisionError("a bug")
            return super().edge_free(q0, q1, resolution)

    with pytest.raises(ZeroDivisionError, match="a bug"):
        plan(Broken())


def test_the_panda_moves_round_a_pillar_and_its_timed_curve_is_free(panda):
    pillar = load_geometry(Box((0.1, 0.1, 1.0)))
    T = np.eye(4)
    T[:3, 3] = (0.15, 0.0, 0.5)
    checker = World(panda, {"pillar": pillar}).checker(Scene({"pillar": T}), margin=0.005)
    start, goal = panda.home.copy(), panda.home.copy()
    start[0], goal[0] = -0.9, 0.9
    assert not checker.edge_free(start, goal)
    result = plan_motion(checker, panda.lower, panda.upper, start, goal, seed=3, timeout=10.0)
    assert checker.path_free(result.path, 0.01)
    timed = time_free_path(result.path, panda.spec, checker)
    assert checker.path_free(timed.trajectory.positions, 0.01)
    blocked = plan_motion(checker, panda.lower, panda.upper, start, panda.home, seed=3, timeout=10.0)
    assert "pillar" in blocked.bodies and "pillar" in blocked.reason


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
