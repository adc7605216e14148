"""What has to be turned over is, on the table, so that one grasp brings it to its goal from there."""

from __future__ import annotations

import math

import pytest

from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization import goal_order
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.serialization.turning_over import turn_over
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.goal_graph import asking_for
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, Asker
from tamp.task import At, Box, Object, Pose, Task, load_robot
from tests.pipeline.samplers import NO_HANDS

BRICK = Box((0.09, 0.04, 0.03))
THERE = Pose.from_rpy((0.1, -0.2, 0.016), (math.pi, 0.0, 0.0))
BELOW = Object("brick", BRICK, Pose((0.1, 0.1, 0.015)), At(THERE))


def attempt(*objects, samplers=None):
    setup = prepare(Task("turn", objects))
    return Attempt.of(setup, setup.start, load_robot("panda").home, samplers)


def asker_of(*objects):
    return Asker(Progress(attempt(*objects)), 0, math.inf, "adaptive")


def test_one_grasp_brings_it_to_its_goal_once_it_is_turned_over():
    asker = asker_of(BELOW)
    assert turn_over(asker, "brick", ())
    lies, goal = asker.workspace.start["brick"], asker.workspace.goals["brick"]
    assert lies.on == ("table",)
    assert lies.pose.matrix[2, :3] @ goal.pose.matrix[2, :3] > 0.25
    asked = asking_for(asker.workspace, {"brick"})
    assert asker.ask(asked, EFFORTS[0].iterations, {"brick"}).plan is not None


@pytest.mark.parametrize(
    "objects",
    [
        (Object("brick", BRICK, Pose((0.1, 0.1, 0.015)), At(Pose((0.1, -0.2, 0.015)))),),
        (BELOW, Object("on it", Box((0.03, 0.03, 0.03)), Pose((0.1, 0.1, 0.045)))),
    ],
)
def test_nothing_is_done_with_what_lies_as_it_shall_or_carries_something(objects):
    asker = asker_of(*objects)
    assert not turn_over(asker, "brick", ())
    assert not asker.progress.actions


def test_what_does_not_get_to_its_goal_is_turned_over_once(monkeypatch):
    asked: list[str] = []
    monkeypatch.setattr(goal_order, "turn_over", lambda asker, name, kept: asked.append(name))
    level = Object("level", BRICK, Pose((0.1, 0.3, 0.015)), At(Pose((-0.1, -0.2, 0.016))))
    Ordering(attempt(BELOW, level, samplers=NO_HANDS), 0, math.inf, "adaptive").run()
    assert asked == ["brick"]
