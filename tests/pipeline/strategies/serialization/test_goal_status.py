from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization import goal_status as early
from tamp.pipeline.strategies.serialization.feasibility import Prospects
from tamp.pipeline.strategies.serialization.goal_status import BroughtNear, GoalStatus
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import Asker
from tamp.task import At, Pose, Task, load_robot
from tests.pipeline.strategies.serialization.test_goal_order import BOARD, CLOSE, CUBE, RED, TOP, attempt


def test_what_has_no_hope_is_brought_near_once_if_far_and_not_to_where_others_shall_be(monkeypatch):
    setup = prepare(Task("far", (RED, TOP, CUBE, CLOSE)))
    asker = Asker(Progress(Attempt.of(setup, setup.start, load_robot("panda").home, None)), 0, math.inf, "adaptive")
    here, asked = asker.workspace.start, []
    monkeypatch.setattr(early, "bring_near", lambda _, names, __, free: asked.append((names, free)) or True)
    without_hope = BroughtNear(Prospects(asker, {name: (here[name], "no grasp") for name in ("red", "close")}))
    names = ["red", "top", "cube", "close"]
    assert not any(without_hope.bring(name, names, ()) for name in names)  # before it is time for that
    without_hope.since = 0.0
    assert [without_hope.bring(name, names, ()) for name in (*names, "top")] == [True, True, False, False, False]
    assert asked == [({"red"}, {"cube"}), ({"top"}, {"cube"})]


def status(*objects, unsteady=()):
    return GoalStatus(Asker(Progress(attempt(Task("goals", objects))), 0, math.inf, "adaptive"), unsteady)


@pytest.mark.parametrize(("off", "near"), [(0.02, True), (0.04, False)])
def test_what_is_near_its_goal_counts_as_there_and_stands_at_it_from_then_on(off, near):
    x, y, z = RED.goal.pose.xyz
    goals = status(replace(RED, pose=Pose((x + off, y, z))))
    assert goals.reach_near(["red"]) is near
    assert (goals.reached, set(goals.left)) == (({"red"}, set()) if near else (set(), {"red"}))
    workspace = goals.asker.workspace
    assert (workspace.goals["red"] == workspace.start["red"]) is near


@pytest.mark.parametrize(("unsteady", "left"), [((), {"near", "far"}), (("near", "far"), {"far"})])
def test_what_can_be_grasped_is_not_given_up_while_others_are_far_unless_it_ends_elsewhere(unsteady, left):
    near, far = (replace(RED, name=name, pose=Pose((x, -0.2, 0.04))) for name, x in (("near", 0.07), ("far", 0.25)))
    goals = status(near, replace(far, goal=At(Pose((0.25, 0.2, 0.04)))), unsteady=unsteady)
    goals.reach_troublesome()
    assert set(goals.left) == left


@pytest.mark.parametrize(("off", "left"), [(0.2, ["red"]), (0.0, ["board", "red"])])
def test_what_lies_too_flat_for_any_hand_near_its_goal_stays_there_while_others_are_far(off, left):
    board = replace(BOARD, goal=At(Pose((-0.03, 0.3, 0.01))))
    red = replace(RED, pose=Pose((0.05, off - 0.2, 0.04)))
    goals = status(board, red)
    goals.reach_troublesome()
    assert list(goals.left) == left
