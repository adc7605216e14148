from __future__ import annotations

import numpy as np
import pytest

from tamp.streams.motion.handling_contacts import approach_contact
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.pushing.grasp_after_push import sample_exposed_grasp
from tamp.streams.pushing.push_motion import push_hits
from tamp.streams.pushing.topple import plan_toppling
from tamp.streams.values import Placement
from tamp.task import Box, Object, Pose
from tests.streams.affordances.test_topple_path import PAIL
from tests.streams.tables import ToldContext, workspace_of

PEG = Object("peg", Box((0.02, 0.02, 0.02)), Pose((0.1, 0.4, 0.01)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(PAIL, PEG)


@pytest.fixture(scope="module")
def offer(workspace):
    return next(plan_toppling(ToldContext(workspace), "pail", workspace.start["pail"]))


def test_the_hand_turns_the_object_about_the_edge_to_where_it_falls(workspace, offer):
    _, before, after, slide = offer
    robot = workspace.world.robot
    for q, pose in ((slide.push[0], workspace.start["pail"].pose), (slide.push[-1], slide.fall[0])):
        np.testing.assert_allclose(robot.forward(q) @ slide.T_tool_object.matrix, pose.matrix, atol=1e-4)
    for q in slide.push:
        T = robot.forward(q) @ slide.T_tool_object.matrix
        assert (workspace.points("pail") @ T[2, :3] + T[2, 3]).min() == pytest.approx(0.0, abs=1e-3)
    assert before.q == tuple(slide.approach[0]) and after.q == tuple(slide.retreat[-1])


def test_the_hand_comes_down_clear_of_the_object_and_then_touches_it(workspace, offer):
    slide, start = offer[-1], workspace.start["pail"].pose
    assert approach_contact(workspace, "pail", start, slide.opening, slide.approach, {}) is None
    assert approach_contact(workspace, "pail", start, slide.opening, slide.push[:3], {}) is not None


def test_as_it_lies_it_can_be_gripped(workspace, offer):
    context, (end, *_) = ToldContext(workspace), offer
    grasps = sample_exposed_grasp(context, "pail", end)
    assert any(next(inverse_kinematics(context, "pail", end, grasp), None) is not None for grasp in grasps)


def test_what_stands_where_it_falls_is_hit_and_what_stands_elsewhere_is_not(workspace, offer):
    end, _, _, slide = offer
    below = Placement(Pose((*end.pose.xyz[:2], 0.01)), ("table",))
    assert "pushed into peg" in push_hits(workspace, slide, {"peg": below})
    assert push_hits(workspace, slide, {"peg": workspace.start["peg"]}) is None


def test_topples_that_are_free_of_what_stands_there_come_first(workspace, offer):
    around = (("AtPose", "peg", Placement(Pose((*offer[0].pose.xyz[:2], 0.01)), ("table",))),)
    offers = list(plan_toppling(ToldContext(workspace, bound=around), "pail", workspace.start["pail"]))
    free = [push_hits(workspace, slide, {"peg": around[0][2]}) is None for *_, slide in offers]
    assert free == sorted(free, reverse=True) and any(free) and not all(free)
