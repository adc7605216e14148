from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tamp.checking.actions.fall import check_fall
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.formats.obj import box_obj
from tamp.streams.affordances.falls import (
    HEIGHTS,
    drops,
    learn_jolts,
    learn_too_high,
    letting_go,
    may_fall,
    refused,
)
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.hand.finger_closing import between_pads
from tamp.streams.motion.inverse_kinematics import handlings, inverse_kinematics
from tamp.streams.releasing.tilted_release import lays, plan_bringing, plan_laying
from tamp.streams.values import Placement
from tamp.streams.workspace import HandMotion
from tamp.task import At, Box, Fall, Mesh, Object, Pose
from tests.streams.tables import OBJECTS, SLAB, ToldContext, at, corners, workspace_of

CRATE = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj", 1.5), Pose((0.10, -0.22, 0.045)))
GOAL = Pose((0.012, -0.352, 0.022))
BLOCK = Object("block", Box((0.04, 0.05, 0.03)), Pose.from_rpy((0.05, 0.2, 0.015), (0.0, 0.0, 0.4)), At(GOAL))


def inside(pose=GOAL, *others):
    """A block whose goal is in a deep box."""
    workspace = workspace_of(Object("block", BLOCK.shape, BLOCK.pose, At(pose)), CRATE, *others)
    return replace(workspace, goals={"block": Placement(pose, ("crate",))})


@pytest.fixture(scope="module")
def workspace():
    return inside()


@given(x=st.floats(0.02, 0.18), y=st.floats(-0.34, -0.10), yaw=st.floats(-3.0, 3.0))
@settings(max_examples=15, deadline=None)
def test_a_drop_goes_straight_down_to_the_placement(x, y, yaw):
    goal = Pose.from_rpy((x, y, 0.022), (0.0, 0.0, yaw))
    workspace = inside(goal)
    found = drops(workspace, "block", workspace.goals["block"])
    assert [round(fall[0].xyz[2] - goal.xyz[2], 6) for fall in found] in [list(HEIGHTS), []]
    for fall in found:
        assert fall[-1] == goal
        heights = [pose.xyz[2] for pose in fall]
        assert heights == sorted(heights, reverse=True)
        assert {(pose.xyz[:2], pose.quat) for pose in fall} == {(goal.xyz[:2], goal.quat)}


def test_what_stands_on_the_table_or_on_a_slab_is_not_dropped():
    on_slab = Object("block", BLOCK.shape, BLOCK.pose, At(Pose((0.05, -0.05, 0.045))))
    workspace = workspace_of(on_slab, SLAB)
    assert not drops(workspace, "block", workspace.start["block"])
    assert not drops(workspace, "block", workspace.goals["block"])
    workspace = replace(workspace, goals={"block": Placement(workspace.goals["block"].pose, ("slab",))})
    assert not drops(workspace, "block", workspace.goals["block"])


def test_nothing_is_dropped_through_a_wall():
    leaning = Pose.from_rpy((-0.002, -0.22, 0.06), (0.0, 0.9, 0.0))
    across = Pose((0.0, -0.22, 0.03))
    assert not drops(inside(across), "block", Placement(across, ("crate",)))
    assert all(len(fall) > 1 for fall in drops(inside(leaning), "block", Placement(leaning, ("crate",))))


def test_only_a_goal_is_let_fall_to(workspace):
    assert may_fall(workspace, "block", workspace.goals["block"])
    assert not may_fall(workspace, "block", workspace.start["block"])
    x, y, z = workspace.goals["block"].pose.xyz
    elsewhere = Placement(Pose((x, y + 0.001, z), workspace.goals["block"].pose.quat), ("crate",))
    assert letting_go(workspace, "block", elsewhere) == []
    equal = Placement(workspace.goals["block"].pose, ("crate",))
    assert letting_go(workspace, "block", equal) == letting_go(workspace, "block", workspace.goals["block"])
    lowest, *_, highest = letting_go(workspace, "block", workspace.goals["block"])
    assert GOAL.xyz[2] < lowest.xyz[2] < highest.xyz[2] == pytest.approx(GOAL.xyz[2] + HEIGHTS[-1])


def test_a_block_for_the_corner_of_a_deep_box_is_let_go_above_it(workspace):
    crate = at("crate", workspace.start["crate"])
    start, goal = workspace.start["block"], workspace.goals["block"]
    grasp = next(sample_grasp(ToldContext(workspace), "block"))
    assert next(inverse_kinematics(ToldContext(workspace), "block", start, grasp), None) is not None
    _, _, handling = next(plan_laying(ToldContext(workspace, bound=(crate,)), "block", goal, grasp))
    assert handling.dropped
    T_tool = handling.let_go.matrix @ handling.grasp.T_object_tool.matrix
    np.testing.assert_allclose(workspace.world.robot.forward(handling.approach[-1]), T_tool, atol=1e-3)
    assert corners(workspace, "block", handling.let_go)[:, 2].min() > corners(workspace, "block", goal.pose)[:, 2].min()


def test_what_cannot_be_put_into_the_corner_is_brought_there_by_a_drop(workspace):
    context, goal = ToldContext(workspace, bound=(at("crate", workspace.start["crate"]),)), workspace.goals["block"]
    grasp = next(sample_grasp(context, "block"))
    assert lays(context, "block", goal, grasp)
    falls = [handling.dropped for _, _, handling in plan_bringing(context, "block", goal, grasp)]
    assert falls == sorted(falls)
    assert falls[-1]


def test_what_has_fallen_is_not_between_the_fingers_any_more(workspace):
    context, goal = ToldContext(workspace), workspace.goals["block"]
    grasp = next(sample_grasp(context, "block"))
    stroke = workspace.world.robot.spec.gripper.stroke
    found = [handling for _, _, handling in plan_laying(context, "block", goal, grasp)]
    assert found
    for handling in found:
        T_object_tool = goal.pose.inverse().matrix @ workspace.world.robot.forward(handling.approach[0])
        assert not len(between_pads(workspace, "block", T_object_tool, stroke))


def test_nothing_is_dropped_that_would_stay_between_the_fingers(workspace):
    context = ToldContext(replace(workspace, hand=HandMotion(withdrawals=(0.001,))))
    goal = workspace.goals["block"]
    grasp = next(sample_grasp(context, "block"))
    low = (Pose((*goal.pose.xyz[:2], goal.pose.xyz[2] + 0.002), goal.pose.quat), goal.pose)
    assert list(handlings(context, "block", goal, grasp, low)) == []
    assert "block would not fall out of the hand" in context.reasons


POST = Object("post", Box((0.03, 0.03, 0.03)), Pose((0.10, -0.22, 0.024)))


def on_post(aside, tall):
    """A block on a post in a deep box, its middle so far inside the post's edge, and the drops that planning offers."""
    place = Placement(Pose((0.10 + 0.015 - aside, -0.22, 0.039 + tall / 2)), ("post",))
    shape = Box((0.05, 0.03, tall))
    workspace = workspace_of(Object("block", shape, BLOCK.pose, At(place.pose)), CRATE, POST, on={"post": ("crate",)})
    workspace = replace(workspace, goals={"block": place})
    return workspace, place, drops(workspace, "block", place)


@given(aside=st.floats(0.0005, 0.012), tall=st.floats(0.02, 0.06))
@settings(max_examples=8, deadline=None)
def test_the_checker_refuses_no_drop_that_planning_offers(aside, tall):
    workspace, place, found = on_post(aside, tall)
    scene, said = Scene.of(workspace.task), []
    for fall in found[-1:]:
        poses = {"block": fall[0].matrix, "crate": CRATE.pose.matrix, "post": POST.pose.matrix}
        state = State(poses, np.array(workspace.world.robot.spec.home))
        check_fall(scene, state, Fall("block", place.pose), DEFAULT, lambda kind, told, **more: said.append(told))
    assert said == []


@example(wide=0.006, tall=0.05, shift=0.0)
@given(wide=st.floats(0.006, 0.03), tall=st.floats(0.02, 0.05), shift=st.floats(-0.01, 0.01))
@settings(max_examples=8, deadline=None)
def test_nor_one_on_several_carriers_each_of_which_may_be_met_first(wide, tall, shift):
    slab = Object("slab", Box((0.12, 0.1, 0.01)), Pose((0.10, -0.22, 0.014)))
    shape = Box((wide, 0.02, tall))
    posts = [Object(f"post_{x:g}", shape, Pose((0.10 + x, -0.22, 0.019 + tall / 2))) for x in (-0.03, 0.03)]
    place = Placement(Pose((0.10 + shift, -0.22, 0.029 + tall)), tuple(post.name for post in posts))
    block = Object("block", Box((0.09, 0.04, 0.02)), BLOCK.pose, At(place.pose))
    on = {"slab": ("crate",), **{post.name: ("slab",) for post in posts}}
    workspace = replace(workspace_of(block, CRATE, slab, *posts, on=on), goals={"block": place})
    standing = {body.name: body.pose.matrix for body in (CRATE, slab, *posts)}
    scene, said = Scene.of(workspace.task), []
    for fall in drops(workspace, "block", place)[-1:]:
        state = State({**standing, "block": fall[0].matrix}, np.array(workspace.world.robot.spec.home))
        check_fall(scene, state, Fall("block", place.pose), DEFAULT, lambda kind, told, **more: said.append(told))
    assert [told for told in said if "tips over" in told] == []


@example(reach=0.04, gap=0.0035)
@given(reach=st.floats(0.0, 0.08), gap=st.floats(0.001, 0.006))
@settings(max_examples=8, deadline=None)
def test_nor_one_onto_what_only_walls_that_may_not_touch_it_keep_from_tipping(reach, gap):
    """A slab on a post tips with the block that comes down on its end, though it nearly reaches from wall to wall."""
    slab = Object("slab", Box((0.228 - 2 * gap, 0.05, 0.02)), Pose((0.10, -0.22, 0.049)))
    place = Placement(Pose((0.10 + reach, -0.22, 0.079)), ("slab",))
    block = Object("block", Box((0.03, 0.03, 0.04)), BLOCK.pose, At(place.pose))
    on = {"post": ("crate",), "slab": ("post",)}
    workspace = replace(workspace_of(block, CRATE, POST, slab, on=on), goals={"block": place})
    standing = {body.name: body.pose.matrix for body in (CRATE, POST, slab)}
    scene, said = Scene.of(workspace.task), []
    for fall in drops(workspace, "block", place)[-1:]:
        state = State({**standing, "block": fall[0].matrix}, np.array(workspace.world.robot.spec.home))
        check_fall(scene, state, Fall("block", place.pose), DEFAULT, lambda kind, told, **more: said.append(told))
    assert said == []


def test_the_less_firmly_it_will_stand_the_lower_it_is_let_go():
    counts = [len(on_post(aside, 0.05)[2]) for aside in (0.003, 0.004, 0.012)]
    assert counts == sorted(counts)
    assert 0 <= counts[0] < counts[-1] == len(HEIGHTS)


def test_what_is_learnt_of_a_fall_holds_for_it_and_higher_ones_while_the_pile_stands(workspace):
    goal = workspace.goals["block"]
    heights = [fall[0].xyz[2] for fall in drops(workspace, "block", goal)]
    fresh = inside()
    learn_too_high(fresh, "block", goal, raised(goal.pose, HEIGHTS[2]))
    learn_too_high(fresh, "block", goal, raised(goal.pose, HEIGHTS[3]))
    assert [fall[0].xyz[2] for fall in drops(fresh, "block", goal)] == heights[:2]
    elsewhere = replace(goal, pose=Pose((goal.pose.xyz[0] + 0.001, *goal.pose.xyz[1:])))
    assert len(drops(fresh, "block", elsewhere)) > 2


def test_what_would_not_stay_beside_it_bars_falls_from_as_high_to_places_near_by_too():
    workspace = inside()
    goal = workspace.goals["block"]
    elsewhere = replace(goal, pose=Pose((goal.pose.xyz[0] + 0.001, *goal.pose.xyz[1:])))
    least = [fall[0].xyz[2] for fall in drops(workspace, "block", elsewhere)][:2]
    learn_jolts(workspace, "block", goal, raised(goal.pose, HEIGHTS[2]))
    assert [fall[0].xyz[2] for fall in drops(workspace, "block", elsewhere)] == least
    assert refused(workspace, "block", elsewhere, raised(elsewhere.pose, HEIGHTS[3]))
    assert not refused(workspace, "block", elsewhere, raised(elsewhere.pose, HEIGHTS[1]))


def test_how_far_something_falls_is_told_by_its_middle_wherever_its_origin_is(tmp_path):
    """Let go tilted, its origin, which is 10 cm aside of it, is lower than where it comes to lie."""
    (tmp_path / "block.obj").write_text(box_obj("block", (0.085, -0.015, -0.02), (0.115, 0.015, 0.02)))
    aside, height = Pose((0.1, 0.0, 0.0)), HEIGHTS[2]
    place = Placement(GOAL @ aside.inverse(), ("crate",))
    block = Object("block", Mesh(tmp_path / "block.obj"), BLOCK.pose @ aside.inverse(), At(place.pose))
    workspace = replace(workspace_of(block, CRATE), goals={"block": place})
    tilted = raised(GOAL, height) @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -0.5, 0.0)) @ aside.inverse()
    assert tilted.xyz[2] < place.pose.xyz[2]
    learn_jolts(workspace, "block", place, tilted)
    assert refused(workspace, "block", place, raised(place.pose, height))
    assert not refused(workspace, "block", place, raised(place.pose, HEIGHTS[1]))


def raised(pose, height):
    x, y, z = pose.xyz
    return Pose((x, y, z + height), pose.quat)
