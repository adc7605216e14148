from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from tamp.streams.affordances.stable_poses import amid, resting, stands, tips_at
from tamp.streams.affordances.tilts import layable, tilts
from tamp.streams.hand.clearance import hand_above_table, opening_for
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.motion.inverse_kinematics import handlings
from tamp.streams.placing import sampler
from tamp.streams.placing.regrasp import regrasping, sample_regrasp
from tamp.task import At, Box, Cylinder, Object, Pose
from tamp.world.scene import Scene
from tests.streams.tables import SLAB, ToldContext, at, panda, workspace_of

BLOCK = Object(
    "block",
    Box((0.04, 0.1, 0.06)),
    Pose((0.05, 0.15, 0.031)),
    At(Pose.from_rpy((0.05, -0.15, 0.021), (0.0, np.pi / 2, 0.0))),
)
"""Can only be taken across its x side, and only be put down across its z side."""


@pytest.fixture(scope="module")
def table():
    return workspace_of(BLOCK, SLAB)


def regrasps(workspace, name, count=3, seed=0, sampler=sample_regrasp, bound=()):
    context = ToldContext(workspace, seed, bound=bound)
    start, goal = workspace.start[name], workspace.goals[name]
    return list(islice(sampler(context, name, start, goal), count)), context.reasons


@pytest.mark.parametrize("seed", range(2))
def test_both_hands_have_room_where_the_object_is_put_down_in_between(table, seed):
    found, _ = regrasps(table, "block", seed=seed)
    assert found
    start, goal = table.start["block"], table.goals["block"]
    for first, between, second in found:
        assert between.on == ("table",)
        assert stands(table.world.geometries["block"], between.pose.matrix[:3, :3])
        for place, grasp in ((start, first), (between, first), (between, second), (goal, second)):
            tool = place.pose.matrix @ grasp.T_object_tool.matrix
            opening = opening_for(panda().spec.gripper, grasp)
            assert table.world.hand_contact(tool, opening, Scene(), margin=0.0) is None
            assert next(handlings(ToldContext(table), "block", place, grasp), None) is not None


def test_each_grasp_is_tried_before_any_is_tried_with_another_partner(table):
    found, _ = regrasps(table, "block", count=4)
    assert len({first for first, _, _ in found}) == len({second for _, _, second in found}) == 4


@pytest.mark.parametrize("seed", range(2))
def test_grasps_come_first_that_take_the_object_up_beside_what_stands_there(seed):
    post = Object("post", Box((0.03, 0.03, 0.2)), Pose((0.1, 0.15, 0.1)))
    workspace = workspace_of(BLOCK, post)
    place, around = workspace.start["block"], {"post": workspace.start["post"]}
    ((first, _, _), *_), _ = regrasps(workspace, "block", count=1, seed=seed, bound=(at("post", around["post"]),))
    ways = [handling for _, _, handling in handlings(ToldContext(workspace), "block", place, first)]
    assert not all(handling_hits(workspace, handling, around) for handling in ways)


def test_the_object_is_put_down_where_nothing_stands_and_nothing_shall_stand(table):
    bound = (at("slab", table.start["slab"]),)
    for _, between, _ in regrasps(table, "block", bound=bound)[0]:
        for other in (table.start["slab"], table.goals["block"]):
            name = "slab" if other is table.start["slab"] else "block"
            T = between.pose.matrix
            assert not table.world.overlap("block", T, name, other.pose.matrix, tolerance=0.0)


def test_the_grasps_may_be_a_researchers_own(table):
    ((first, _, second), *_), _ = regrasps(table, "block")
    own = regrasping(lambda context, obj: iter((second, first)))
    found, _ = regrasps(table, "block", sampler=own)
    assert {(one, other) for one, _, other in found} == {(first, second)}


def test_what_cannot_be_taken_up_is_not_regrasped():
    wide = Object("wide", Box((0.2, 0.2, 0.02)), Pose((0.05, 0.2, 0.011)), At(Pose((0.05, -0.2, 0.011))))
    found, reasons = regrasps(workspace_of(wide), "wide")
    assert not found
    assert "no grasp of wide takes it up" in reasons


COIN = Object(
    "coin", Cylinder(0.035, 0.02), Pose((0.05, 0.2, 0.011)), At(Pose.from_rpy((0.05, -0.2, 0.011), (np.pi, 0.0, 0.0)))
)


def test_a_coin_is_turned_over_where_it_is_laid_down_in_between():
    found, _ = regrasps(workspace_of(COIN), "coin")
    assert found
    for first, between, _ in found:
        assert between.pose.matrix[2, 2] == pytest.approx(-1.0)
        tool = between.pose.matrix @ first.T_object_tool.matrix
        assert workspace_of(COIN).world.hand_contact(tool, 0.08, Scene(), margin=0.0) == "table"  # it cannot be put


def test_what_can_be_laid_down_from_most_tilts_is_tried_first():
    workspace = workspace_of(COIN)
    found, _ = regrasps(workspace, "coin", count=4)
    ways = [_tilts_with_room(workspace, grasp) for grasp, _, _ in found]
    assert ways[0] > ways[-1] and ways == sorted(ways, reverse=True)


def _tilts_with_room(workspace, grasp):
    places = [amid(workspace, "coin", R) for R in resting(workspace, "coin")]
    able = [tilts(workspace, "coin", place) for place in places if layable(workspace, "coin", place)]
    return max(sum(hand_above_table(workspace, tilt.fall[0], grasp) for tilt in each) for each in able)


def test_what_rests_on_no_face_is_not_regrasped(monkeypatch):
    monkeypatch.setattr("tamp.streams.placing.regrasp.resting", lambda workspace, obj: [])
    found, reasons = regrasps(workspace_of(COIN), "coin")
    assert not found
    assert reasons == [
        "coin has no face to rest on with room for the hands of two grasps that reach it",
        "no place for coin over an edge of the table that two grasps reach",
    ]


@pytest.mark.parametrize(("loose", "steady"), [(0.2, False), (0.245, True)])
def test_what_turns_in_the_hand_is_put_down_on_a_face_from_which_it_does_not_tip_over(monkeypatch, loose, steady):
    """A slab that stands has to be turned upside down: on another narrow side it tips at 0.46 rad, lying at 1.1."""
    monkeypatch.setattr(sampler, "unsteadiness", lambda *_: loose)
    upside_down = At(Pose.from_rpy((0.05, -0.15, 0.031), (np.pi, 0.0, 0.0)))
    table = workspace_of(Object("slab", Box((0.03, 0.06, 0.06)), Pose((0.05, 0.15, 0.031)), upside_down))
    found, _ = regrasps(table, "slab", count=8)
    tips = [tips_at(table.world.geometries["slab"], place.pose.matrix[:3, :3]) for _, place, _ in found]
    assert len(tips) == 8
    assert (min(tips) > 2 * 0.245) == steady
