from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.affordances.neighbours import beneath, standing_around
from tamp.streams.grasping.hand_clearance import HINDERED, neighbour_cost, support_cost, tilt_cost
from tamp.streams.hand.candidates import Pinches, sample_pinches
from tamp.streams.hand.clearance import (
    above_table,
    caught,
    clear_of_falling,
    clear_of_object,
    first_clear,
    hand_hits,
    opening_for,
    openings_of,
)
from tamp.streams.hand.hand_boxes import hand_boxes, points_hit
from tamp.streams.values import CLEARANCE, Grasp, Placement
from tamp.task import At, Box, Object, Pose
from tamp.world.scene import Scene
from tests.streams.tables import CUBE, RED, SLAB, panda, workspace_of

GRIPPER = panda().spec.gripper
DOWN = Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)).matrix
"""From above, the pads' middle 2 cm over the middle of the object."""
SIDE = Pose.from_rpy((-0.01, 0.0, 0.0), (0.0, np.pi / 2, 0.0)).matrix
UP = Pose.from_rpy((0.0, 0.0, -0.02), (0.0, 0.0, 0.0)).matrix


def pinches_at(*tools, width=0.05):
    count = len(tools)
    return Pinches(
        np.array(tools), np.full(count, width), np.full(count, 0.012), np.zeros(count), np.full(count, CLEARANCE)
    )


@given(width=st.floats(0.0, GRIPPER.stroke))
def test_the_hand_opens_wider_than_the_object_but_not_beyond_the_stroke(width):
    opening = opening_for(GRIPPER, Grasp(Pose(), width))
    assert width <= opening <= GRIPPER.stroke
    assert opening == pytest.approx(min(GRIPPER.stroke, width + 2 * CLEARANCE))


def test_a_hand_from_above_is_over_the_table_and_one_from_below_is_not(table):
    low = SIDE.copy()
    low[2, 3] = -0.035
    usable = above_table(table, pinches_at(DOWN, low, UP), table.start["red"])
    assert usable.tolist() == [True, False, False]


def test_leaning_away_from_the_vertical_costs_more(table):
    down, side = tilt_cost(pinches_at(DOWN, SIDE), table.start["red"])
    assert down == pytest.approx(0.0, abs=1e-6)
    assert side > 0.5


def test_a_palm_inside_the_object_is_not_clear_of_it(table):
    sunk = DOWN.copy()
    sunk[2, 3] = -0.06
    assert clear_of_object(table, "red", pinches_at(DOWN, sunk)).tolist() == [True, False]


def test_a_hand_in_a_thin_wall_of_the_object_is_not_clear_of_it():
    wall = Object("wall", Box((0.3, 0.003, 0.2)), Pose((0.0, 0.0, 0.1)))
    workspace = workspace_of(wall)
    pinches = sample_pinches(workspace, "wall", np.random.default_rng(0))
    tools, openings = pinches.T_object_tool, openings_of(workspace, pinches)
    points = points_hit(hand_boxes(panda()), openings, tools, workspace.surface["wall"])
    clear = clear_of_object(workspace, "wall", pinches)
    alone = Scene({"wall": np.eye(4)})
    free = [
        workspace.world.hand_contact(T, w, alone, margin=0.0) != "wall" for T, w in zip(tools, openings, strict=True)
    ]
    assert not (clear & ~np.array(free)).any()
    assert clear.sum() < (~points).sum()  # points on the surface alone would let some of them pass


def test_a_neighbour_in_the_way_is_hit_and_costs():
    near = Object("near", CUBE.shape, Pose((0.05, 0.2 + 0.047, 0.06)))
    workspace = workspace_of(RED, near)
    tool = RED.pose.matrix @ DOWN
    assert hand_hits(workspace, tool, 0.066, Scene({"near": near.pose.matrix}))
    assert not hand_hits(workspace, tool, 0.066, Scene())
    hit, turned = neighbour_cost(
        workspace, pinches_at(DOWN, DOWN @ Pose.from_rpy((0, 0, 0), (0, 0, np.pi / 2)).matrix), "red",
        workspace.start["red"],
    )  # fmt: skip
    assert hit == 1.0
    assert turned == 0.0


def test_the_hand_hits_the_table_when_it_reaches_through_it(table):
    T = DOWN.copy()
    T[2, 3] = 0.0
    assert hand_hits(table, T, 0.05, Scene())


def test_meeting_the_support_hinders():
    board = Object("board", Box((0.2, 0.2, 0.02)), Pose((0.0, 0.0, 0.01)))
    chip = Object("chip", Box((0.05, 0.05, 0.02)), Pose((0.0, 0.0, 0.03)))
    workspace = workspace_of(board, chip, on={"chip": ("board",)})
    shallow, deep = np.eye(4), np.eye(4)
    shallow[:3, :3] = deep[:3, :3] = DOWN[:3, :3]
    shallow[2, 3], deep[2, 3] = 0.01, -0.01
    costs = support_cost(workspace, pinches_at(shallow, deep), "chip", workspace.start["chip"])
    assert costs.tolist() == [0.0, HINDERED]


def test_fingers_that_would_close_over_the_support_are_hindered():
    post = Object("post", Box((0.03, 0.03, 0.06)), Pose((0.0, 0.0, 0.03)))
    chip = Object("chip", Box((0.03, 0.03, 0.03)), Pose((0.0, 0.0, 0.075)))
    workspace = workspace_of(post, chip, on={"chip": ("post",)})
    low = Pose.from_rpy((0.0, 0.0, -0.012), (np.pi, 0.0, 0.0)).matrix
    tool, support = chip.pose.matrix @ low, Scene({"post": post.pose.matrix})
    assert not hand_hits(workspace, tool, opening_for(GRIPPER, Grasp(Pose(), 0.03)), support)
    assert support_cost(workspace, pinches_at(low, width=0.03), "chip", workspace.start["chip"]).tolist() == [HINDERED]


def test_what_stands_on_nothing_but_the_table_has_no_support_in_the_way(table):
    assert support_cost(table, pinches_at(DOWN), "red", table.start["red"]).tolist() == [0.0]


def test_around_a_goal_stand_the_goals_and_around_a_start_the_starts():
    moving = Object("cube", CUBE.shape, CUBE.pose, At(Pose((0.15, 0.3, 0.02))))
    workspace = workspace_of(RED, SLAB, moving)
    assert standing_around(workspace, "red", workspace.start["red"]) == {
        "cube": workspace.start["cube"],
        "slab": workspace.start["slab"],
    }
    assert standing_around(workspace, "red", workspace.goals["red"]) == {
        "cube": workspace.goals["cube"],
        "slab": workspace.start["slab"],
    }


def test_what_carries_an_object_through_others_is_beneath_it_too():
    around = {
        "cup": Placement(Pose(), ("plate",)),
        "plate": Placement(Pose(), ("table", "tray")),
        "tray": Placement(Pose(), ("table",)),
        "jar": Placement(Pose(), ("tray",)),
    }
    assert beneath(Placement(Pose(), ("cup",)), around) == ["cup", "plate", "tray"]
    assert beneath(Placement(Pose(), ("table",)), around) == []


def test_an_object_falls_out_of_a_hand_above_it_but_onto_a_finger_below_it(table):
    level = pinches_at(SIDE)
    assert clear_of_falling(table, "red", pinches_at(DOWN), Pose()).tolist() == [True]
    assert clear_of_falling(table, "red", level, Pose()).tolist() == [True]
    on_its_side = Pose.from_rpy((0.0, 0.0, 0.0), (np.pi / 2, 0.0, 0.0))
    assert clear_of_falling(table, "red", level, on_its_side).tolist() == [False]


PLATE = Object("plate", Box((0.08, 0.005, 0.06)), Pose((0.0, 0.0, 0.5)), goal=At(Pose((0.0, 0.0, 0.5))))


@given(slant=st.floats(-0.6, 0.6), height=st.floats(0.01, 0.06), held=st.floats(0.005, 0.03))
@settings(max_examples=40)
def test_what_falls_aslant_out_of_the_hand_is_caught_where_it_meets_a_finger_for_a_millimetre(slant, height, held):
    workspace = workspace_of(PLATE)
    let_go = Pose.from_rpy((0.0, 0.0, 0.5), (slant, 0.0, 0.0))
    tool = let_go.matrix @ Pose.from_rpy((0.0, 0.0, held), (np.pi, 0.0, 0.0)).matrix
    fall = (let_go, Pose((0.0, 0.0, 0.5 - height), let_go.quat))
    depths = np.arange(0.0, height, 1e-4)

    def met(margin):
        scenes = (Scene({"plate": Pose((0.0, 0.0, 0.5 - depth), let_go.quat).matrix}) for depth in depths)
        found = [workspace.world.hand_contact(tool, 0.02, scene, margin) is not None for scene in scenes]
        return max((len([*run]) for hit, run in groupby(found) if hit), default=0)

    if caught(workspace, "plate", fall, tool, 0.02):
        assert met(5e-4) > 0
    else:
        assert met(0.0) <= 11


def test_the_first_pose_with_room_for_the_hand_is_found(table):
    grasp = Grasp(Pose.from_matrix(DOWN), 0.05)
    beside, away = (Pose((0.05, y, 0.04)).matrix for y in (0.252, 0.3))
    around = {"red": table.start["red"], "cube": Placement(Pose((0.05, 0.2, 0.05)), ("table",))}
    poses = np.array([beside, away, away])
    assert first_clear(table, grasp, poses, around, "red") == 1
    assert first_clear(table, grasp, poses[:1], around, "red") == 0
    assert first_clear(table, grasp, poses, {"red": Placement(Pose((0.05, 0.3, 0.04)), ("table",))}, "red") == 0
