from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization.goal_stability import GoalStability
from tamp.pipeline.strategies.serialization.partial_plan import Attempt, Progress
from tamp.pipeline.strategies.serialization.subproblem import Asker
from tamp.streams.values import Placement
from tamp.task import At, Pose, Task, load_robot
from tests.checking.test_given_way import rocker, tilted


@pytest.mark.parametrize(("tilt", "awaited", "goes_on"), [(0.14, True, True), (0.0, True, False), (0.14, False, False)])
def test_where_something_of_several_pieces_goes_on_from_its_goal_is_asked_of_physics(
    monkeypatch, tmp_path, tilt, awaited, goes_on
):
    """By 12 mm: contacts within millimetres have it in balance there, and the checker refuses to let it go.

    Where no other is to come that may hold it, its goal is where it has settled.
    """
    monkeypatch.setattr(GoalStability, "awaited", lambda *_: awaited)
    thing, _ = rocker(tmp_path, handle=True, tilt=0.14)
    there = At(Pose((0.05, -0.1, 0.0)))
    setup = prepare(Task("lain", (replace(thing, pose=Pose((0.05, 0.2, 0.0)), goal=there),)))
    begin = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    goal = Placement(Pose((0.05, -0.1, 0.001)) @ Pose.from_matrix(tilted(tilt)), ("table",))
    begin = replace(begin, workspace=replace(begin.workspace, goals={"rocker": goal}))
    asker = Asker(Progress(begin), 0, math.inf, "adaptive")
    assert GoalStability(asker, ()).uncertain("rocker") == goes_on
