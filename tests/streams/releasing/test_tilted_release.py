from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from tamp.checking.geometry.pad_region import between_pads
from tamp.checking.geometry.transforms import inverse
from tamp.checking.scene import Scene as Judged
from tamp.streams.affordances.falls import learn_refused
from tamp.streams.collisions import ARM_MARGIN
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.motion.inverse_kinematics import handlings, inverse_kinematics
from tamp.streams.releasing.tilted_release import letting_go_at, plan_laying
from tamp.streams.values import Placement
from tamp.streams.workspace import HandMotion
from tamp.task import At, Box, Object, Pose
from tamp.world.scene import Scene
from tests.streams.tables import ToldContext, corners, workspace_of

BOOK = Object(
    "book",
    Box((0.15, 0.20, 0.03)),
    Pose.from_rpy((0.1, 0.25, 0.1), (np.pi / 2, 0.0, 0.0)),
    At(Pose.from_rpy((0.1, -0.15, 0.016), (0.0, 0.0, 0.3))),
)
PEG = Object("peg", Box((0.02, 0.02, 0.02)), Pose((0.1, -0.15, 0.01)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOOK, PEG)


@pytest.fixture(scope="module")
def handling(workspace):
    grasp = next(sample_grasp(ToldContext(workspace), "book"))
    _, _, found = next(plan_laying(ToldContext(workspace), "book", workspace.goals["book"], grasp))
    return found


def test_the_first_grasps_serve_to_pick_a_book_up_and_to_lay_it_down(workspace):
    start, goal = workspace.start["book"], workspace.goals["book"]
    grasps = list(islice(sample_grasp(ToldContext(workspace), "book"), 3))
    assert len(grasps) == 3
    for grasp in grasps:
        assert next(inverse_kinematics(ToldContext(workspace), "book", start, grasp), None) is not None
        assert next(inverse_kinematics(ToldContext(workspace), "book", goal, grasp), None) is None
        assert next(plan_laying(ToldContext(workspace), "book", goal, grasp), None) is not None


def test_the_hand_is_at_the_tilted_book_and_out_of_its_way_when_it_falls(workspace, handling):
    robot = workspace.world.robot
    assert handling.fall[-1].xyz == pytest.approx(workspace.goals["book"].pose.xyz)
    T_tool = handling.let_go.matrix @ handling.grasp.T_object_tool.matrix
    np.testing.assert_allclose(robot.forward(handling.approach[-1]), T_tool, atol=1e-3)
    gone = robot.forward(handling.approach[0])[:3, 3]
    fallen = corners(workspace, "book", handling.fall[-1])
    assert np.linalg.norm(fallen - gone, axis=1).min() > 0.03


def test_the_hand_that_has_let_go_is_as_far_from_the_fallen_book_as_its_way_on_asks(workspace):
    goal = workspace.goals["book"]
    for grasp in islice(sample_grasp(ToldContext(workspace), "book"), 4):
        for _, _, found in islice(plan_laying(ToldContext(workspace), "book", goal, grasp), 4):
            scene = Scene({"book": goal.pose.matrix}, opening=found.opening)
            assert workspace.world.checker(scene, margin=ARM_MARGIN).first_contact(found.approach[:1]) is None


def test_what_lies_where_the_book_falls_is_hit(workspace, handling):
    beneath = workspace.start["peg"]
    beside = Placement(Pose((-0.2, 0.4, 0.01)), ("table",))
    assert list(handling_hits(workspace, handling, {"peg": beneath})) == ["peg"]
    assert not handling_hits(workspace, handling, {"peg": beside})


def test_what_shall_lie_on_something_absent_cannot_be_set_on_it(workspace):
    grasp = next(sample_grasp(ToldContext(workspace), "book"))
    context = ToldContext(workspace)
    placement = Placement(workspace.goals["book"].pose, ("shelf",))
    assert next(plan_laying(context, "book", placement, grasp), None) is None
    assert context.reasons == ["book cannot be set on an edge there"]


def test_what_has_fallen_over_is_not_between_the_fingers_any_more(workspace):
    scene, gripper = Judged.of(workspace.task), workspace.world.robot.spec.gripper
    for grasp in islice(sample_grasp(ToldContext(workspace), "book"), 4):
        for _, _, found in islice(plan_laying(ToldContext(workspace), "book", workspace.goals["book"], grasp), 3):
            T_tool = workspace.world.robot.forward(found.approach[0])
            T_tool_object = inverse(T_tool) @ found.fall[-1].matrix
            assert between_pads(scene.solids["book"], T_tool_object, gripper, gripper.stroke) is None


def test_nothing_is_laid_that_would_stay_between_the_fingers(workspace, monkeypatch):
    monkeypatch.setattr("tamp.streams.motion.inverse_kinematics.approach_contact", lambda *asked: None)
    near = replace(workspace, hand=HandMotion(approaches=(0.002,)))
    context, place = ToldContext(near), workspace.goals["book"]
    grasp = next(sample_grasp(ToldContext(workspace), "book"))
    above = Pose((0.1, -0.15, 0.3)) @ workspace.start["book"].pose @ Pose((-0.1, -0.1, -0.25))
    held = above @ Pose.from_rpy((0.0, 0.0, 0.0), (0.02, 0.0, 0.0))
    assert list(handlings(context, "book", place, grasp, (held, above))) == []
    assert "book would not fall out of the hand" in context.reasons


def test_a_fall_that_was_refused_is_not_taken_again(workspace, handling):
    goal, grasp = workspace.goals["book"], handling.grasp
    known = letting_go_at(ToldContext(workspace), "book", goal, grasp)
    fresh = workspace_of(BOOK, PEG)
    learn_refused(fresh, "book", goal, handling.let_go)
    context = ToldContext(fresh)
    left = letting_go_at(context, "book", goal, grasp)
    assert len(known) > 1 and handling.let_go in known
    assert handling.let_go not in left
    assert "book would upset what it falls onto" in context.reasons
    elsewhere = Placement(Pose((0.1, -0.16, 0.016), goal.pose.quat), goal.on)
    assert letting_go_at(ToldContext(fresh), "book", elsewhere, grasp)
