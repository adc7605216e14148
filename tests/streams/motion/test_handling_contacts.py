from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams import collisions
from tamp.streams.motion import handling_contacts
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.values import Grasp, Placement
from tamp.task import Box, Object, Pose
from tests.streams.tables import CUBE, RED, SLAB, ToldContext, workspace_of

FROM_ABOVE = Grasp(Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)), 0.05)


@cache
def scene():
    return workspace_of(RED, SLAB, CUBE)


def placed(x, y, z, yaw=0.0):
    return Placement(Pose.from_rpy((x, y, z), (0.0, 0.0, yaw)), ("table",))


@pytest.fixture(scope="module")
def handling():
    _, _, found = next(inverse_kinematics(ToldContext(scene()), "red", scene().start["red"], FROM_ABOVE))
    return found


def test_a_handling_is_free_of_what_stands_far_away(handling):
    context = ToldContext(scene())
    assert handling_contacts.test_cfree_handling(context, "red", handling, "cube", placed(-0.3, -0.4, 0.02))
    assert not context.reasons


@pytest.mark.parametrize("height", [0.04, 0.2])
def test_a_handling_is_blocked_by_what_stands_in_its_way_and_names_it(handling, height):
    context = ToldContext(scene())
    x, y, _ = RED.pose.xyz
    assert not handling_contacts.test_cfree_handling(context, "red", handling, "slab", placed(x, y + 0.05, height))
    (reason,) = context.reasons
    assert reason.endswith("would hit slab")


def test_everything_that_a_handling_hits_is_named_and_nothing_else(handling):
    x, y, _ = RED.pose.xyz
    beside, far = placed(x, y + 0.05, 0.04), placed(x, y - 0.4, 0.02)
    assert handling_contacts.handling_hits(scene(), handling, {}) == {}
    hits = handling_contacts.handling_hits(scene(), handling, {"slab": beside, "cube": far})
    assert set(hits) == {"slab"}
    assert hits["slab"].endswith("would hit slab")


@given(depth=st.floats(-0.0015, 0.004))
@settings(max_examples=30, deadline=None)
def test_what_is_lifted_gets_hardly_deeper_into_what_it_touches_than_it_was(depth):
    red, cube = placed(0.0, 0.0, 0.04).pose, placed(0.045 - depth, 0.0, 0.02).pose
    nearest = handling_contacts.touched(scene().world, "red", red.matrix, {"cube": cube.matrix})["cube"]
    expected = -max(depth, 0.0) - collisions.SCRAPED
    assert nearest == pytest.approx(max(expected, -collisions.CONTACT_DEPTH), abs=1e-6)


@pytest.mark.parametrize(("gap", "hit"), [(0.001, True), (0.004, False)])
def test_what_is_lifted_ends_clear_of_what_it_touched(gap, hit):
    """It may pass along a wall, but the motion on begins where the lift ends, and none begins in contact."""
    wall = Object("wall", Box((0.02, 0.02, 0.1)), Pose((RED.pose.xyz[0], RED.pose.xyz[1] + 0.035 + gap, 0.05)))
    workspace = workspace_of(RED, wall)
    grasp = Grasp(FROM_ABOVE.T_object_tool @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, np.pi / 2)), 0.05)
    handlings = list(inverse_kinematics(ToldContext(workspace_of(RED)), "red", workspace.start["red"], grasp))
    assert handlings
    hits = [
        handling_contacts.handling_hits(workspace, found, {"wall": workspace.start["wall"]}) for *_, found in handlings
    ]
    assert any(not one for one in hits) != hit
