from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tamp import clock
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.serialization.goal_stability import GoalStability
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import Asker
from tamp.streams.values import Placement
from tamp.task import At, Box, Object, Pose, Task, load_robot
from tests.checking.test_given_way import rocker, tilted


@pytest.mark.parametrize(("tilt", "stays"), [(0.14, False), (0.0, True)])
def test_what_the_checker_refuses_to_have_let_go_at_its_goal_is_not_asked_for_there(tmp_path, tilt, stays):
    """It goes on by 12 mm: contacts within millimetres have it in balance there."""
    thing, _ = rocker(tmp_path, handle=True, tilt=0.14)
    there = At(Pose((0.05, -0.1, 0.0)))
    setup = prepare(Task("lain", (replace(thing, pose=Pose((0.05, 0.2, 0.0)), goal=there),)))
    begin = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    goal = Placement(Pose((0.05, -0.1, 0.001)) @ Pose.from_matrix(tilted(tilt)), ("table",))
    begin = replace(begin, workspace=replace(begin.workspace, goals={"rocker": goal}))
    asker = Asker(Progress(begin), 0, math.inf, "adaptive")
    assert begin.stays("rocker", goal) == stays
    assert GoalStability(asker, ()).uncertain("rocker") != stays


@pytest.mark.parametrize("on_the_block", [True, False])
def test_what_only_something_upon_it_holds_tips_whatever_comes_before(on_the_block):
    """A plank whose middle is beyond a block's edge is held by a weight at its other end, or by a post at this one."""
    block = Object("block", Box((0.1, 0.1, 0.06)), Pose((0.1, 0.0, 0.03)), mass=1.0)
    post = Object("post", Box((0.04, 0.1, 0.06)), Pose((0.1, -0.3, 0.03)), At(Pose((0.24, 0.0, 0.03))), mass=1.0)
    over = At(Pose((0.16, 0.0, 0.07)))
    plank = Object("plank", Box((0.3, 0.06, 0.02)), Pose((0.0, 0.3, 0.01)), over, mass=0.1)
    weight = Object("weight", Box((0.05,) * 3), Pose((0.0, -0.2, 0.025)), At(Pose((0.06, 0.0, 0.105))), mass=1.0)
    task = Task("plank", (block, plank, weight) if on_the_block else (block, post, plank))
    setup = prepare(task)
    begin = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    stability = GoalStability(Asker(Progress(begin), 0, math.inf, "adaptive"), ())
    assert [name for name in begin.workspace.goals if stability.never_stays(name)] == ["plank"] * on_the_block


def test_where_a_goal_never_stays_the_search_ends_and_says_so_before_time_is_up(monkeypatch):
    """Plans for all goals together would be made until then, and refused."""
    monkeypatch.setattr(GoalStability, "never_stays", lambda *_: True)
    monkeypatch.setattr(GoalStability, "stays", lambda *_, **__: False)
    block = Object("block", Box((0.05,) * 3), Pose((0.1, 0.1, 0.025)), At(Pose((0.1, -0.2, 0.025))))
    setup = prepare(Task("slope", (block,)))
    begin = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    ordering = Ordering(begin, 0, clock.now() + 600.0, "adaptive")
    ordering.run(persistent=True)
    assert ordering.left == {"block": "it does not stay there"}
    assert ordering.report.status == "failed"
