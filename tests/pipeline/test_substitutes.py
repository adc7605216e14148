from dataclasses import replace

import pytest

from tamp.pipeline.attempt import Attempt
from tamp.pipeline.setup import prepare
from tamp.pipeline.substitutes import GAIN, substitutes
from tamp.scoring.ede import ede, mean_edge
from tamp.task import At, Box, Object, Pose, Sphere, Task, load_robot

LOW = Object("low", Box((0.12, 0.12, 0.06)), Pose((0.1, 0.3, 0.03)), At(Pose((0.1, -0.1, 0.03))))
HIGH = Object("high", Box((0.05, 0.05, 0.08)), Pose((0.0, 0.2, 0.04)), At(Pose((0.1, -0.1, 0.1))))


@pytest.fixture(scope="module")
def workspace():
    setup = prepare(Task("tower", (LOW, HIGH)))
    return Attempt.of(setup, setup.start, load_robot("panda").home, None).workspace


def test_they_stand_on_the_table_clear_of_all_and_nearer_to_the_goal(workspace):
    places = substitutes(workspace, "high", 4)
    assert places
    edge, goal = mean_edge(HIGH.shape), workspace.goals["high"].pose
    errors = [ede(edge, place.pose, goal) for place in places]
    assert errors == sorted(errors)
    assert errors[-1] < ede(edge, workspace.start["high"].pose, goal) - GAIN
    for place in places:
        assert place.on == ("table",)
        assert not workspace.world.overlap("high", place.pose.matrix, "table", tolerance=0.0)


def test_with_the_support_missing_the_nearest_is_right_under_the_goal(workspace):
    best = substitutes(workspace, "high", 2)[0]
    assert best.pose.xyz[:2] == pytest.approx((0.1, -0.1), abs=2e-3)
    assert best.pose.xyz[2] == pytest.approx(0.041, abs=1e-3)


def test_what_stands_there_is_avoided(workspace):
    goal = workspace.goals["low"]
    now = replace(workspace, start={**workspace.start, "low": goal})
    for place in substitutes(now, "high", 4):
        assert not now.world.overlap("high", place.pose.matrix, "low", goal.pose.matrix, tolerance=0.0)


def test_a_ball_has_some_too():
    ball = Object("ball", Sphere(0.03), Pose((0.0, 0.2, 0.03)), At(Pose((0.1, -0.1, 0.09))))
    setup = prepare(Task("ball", (LOW, ball)))
    workspace = Attempt.of(setup, setup.start, load_robot("panda").home, None).workspace
    assert substitutes(workspace, "ball", 4)


def test_an_object_near_its_goal_has_none(workspace):
    x, y, z = workspace.goals["high"].pose.xyz
    here = replace(workspace.start["high"], pose=Pose((x + 0.01, y, z)))
    assert substitutes(replace(workspace, start={**workspace.start, "high": here}), "high", 4) == []
