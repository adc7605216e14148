from __future__ import annotations

from dataclasses import replace

import pytest

from tamp.pipeline.strategies.subproblems.goal_graph import (
    alone,
    farthest_first,
    nearly_there,
    supports_in_the_way,
)
from tamp.streams.values import Placement
from tamp.task import At, Box, Object, Pose
from tests.streams.tables import workspace_of

TRAY = Object("tray", Box((0.15, 0.15, 0.02)), Pose((0.0, -0.3, 0.01)))
BLOCK = Object("block", Box((0.06, 0.06, 0.04)), Pose((0.0, 0.2, 0.02)), At(Pose((0.0, -0.3, 0.04))))
CUBE = Object("cube", Box((0.04, 0.04, 0.04)), Pose((0.0, 0.2, 0.06)), At(Pose((0.1, 0.0, 0.02))))


def test_what_an_object_stands_on_now_has_no_goal_where_the_object_is_alone():
    workspace = workspace_of(TRAY, BLOCK, CUBE, on={"cube": ("block",)})
    goals = {**workspace.goals, "block": Placement(workspace.goals["block"].pose, ("tray",))}
    only = alone(replace(workspace, goals=goals), "cube")
    assert set(only.start) == {"cube", "block"}
    assert set(only.goals) == {"cube"}


def test_what_an_object_shall_rest_on_stands_where_it_shall_be():
    tray = replace(TRAY, goal=At(Pose((0.0, -0.25, 0.01))))
    workspace = workspace_of(tray, BLOCK, CUBE)
    goals = {**workspace.goals, "block": Placement(workspace.goals["block"].pose, ("tray",))}
    only = alone(replace(workspace, goals=goals), "block")
    assert only.start == {"block": workspace.start["block"], "tray": goals["tray"]}
    assert only.goals == {"block": goals["block"], "tray": goals["tray"]}


def resting_on_a_tray(shift):
    """A block whose goal is on a tray that is so far from its own; a cube 22 cm from its goal."""
    workspace = workspace_of(replace(TRAY, goal=At(Pose((shift, -0.3, 0.01)))), BLOCK, CUBE)
    return replace(workspace, goals={**workspace.goals, "block": Placement(workspace.goals["block"].pose, ("tray",))})


def test_the_farthest_from_its_goal_comes_first_but_after_what_that_rests_on():
    assert farthest_first(resting_on_a_tray(0.3), {"tray", "block", "cube"}) == ["tray", "block", "cube"]
    assert farthest_first(resting_on_a_tray(0.02), {"tray", "cube"}) == ["cube", "tray"]


def test_what_has_much_less_to_gain_than_what_shall_rest_on_it_comes_later():
    assert farthest_first(resting_on_a_tray(0.1), {"tray", "block", "cube"}) == ["block", "cube", "tray"]


def test_a_support_is_in_the_way_only_where_the_object_shall_stand_in_its_place():
    under, aside = At(Pose((0.0, 0.2, 0.02))), At(Pose((0.1, 0.0, 0.02)))
    for goal, found in ((under, ["block"]), (aside, [])):
        workspace = workspace_of(TRAY, BLOCK, replace(CUBE, goal=goal), on={"cube": ("block",)})
        assert supports_in_the_way(workspace, "cube") == found
    assert supports_in_the_way(workspace, "tray") == []


@pytest.mark.parametrize(("shift", "there"), [(0.01, True), (0.1, False)])
def test_what_has_tilted_down_to_the_table_is_nearly_there_once_all_that_it_shall_bear_is(shift, there):
    """A block on a tray touches the table beside it; what shall stand on the block is so far from its goal."""
    block = replace(BLOCK, pose=Pose((0.005, -0.3, 0.04)))
    cube = replace(CUBE, pose=Pose((shift, -0.3, 0.08)), goal=At(Pose((0.0, -0.3, 0.08))))
    workspace = workspace_of(TRAY, block, cube, on={"block": ("table", "tray"), "cube": ("block",)})
    on = {"block": ("tray",), "cube": ("block",)}
    goals = {name: Placement(place.pose, on[name]) for name, place in workspace.goals.items()}
    assert nearly_there(replace(workspace, goals=goals), "block") == there
