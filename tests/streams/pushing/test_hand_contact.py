from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.streams.pushing.hand_contact import hands_behind
from tamp.task import Box, Cylinder, Object, Pose
from tests.streams.tables import workspace_of

AHEAD, HEIGHTS = np.array([1.0, 0.0, 0.0]), np.array([0.06])


@pytest.mark.parametrize(("friction", "slant", "held"), [(0.2, 15.0, False), (0.2, 5.0, True), (0.5, 15.0, True)])
def test_a_flank_is_pushed_no_farther_aslant_than_friction_holds(friction, slant, held):
    block = Object("block", Box((0.1, 0.1, 0.1)), Pose.from_rpy((0.0, 0.0, 0.05), (0.0, 0.0, np.radians(slant))))
    workspace = workspace_of(replace(block, friction=friction))
    hands = hands_behind(workspace, "block", workspace.start["block"], AHEAD, HEIGHTS)
    assert (next(hands, None) is not None) == held


def test_the_flat_of_a_finger_pushes_a_corner_however_slippery_it_is():
    turned = Pose.from_rpy((0.0, 0.0, 0.05), (0.0, 0.0, np.pi / 4))
    workspace = workspace_of(Object("block", Box((0.1, 0.1, 0.1)), turned, friction=0.1))
    assert next(hands_behind(workspace, "block", workspace.start["block"], AHEAD, HEIGHTS), None) is not None


@pytest.mark.parametrize(("highest", "touched"), [(0.034, False), (0.042, True)])
def test_what_bulges_is_touched_above_the_fingertips(highest, touched):
    lying = Pose.from_rpy((0.0, 0.0, 0.05), (np.pi / 2, 0.0, 0.0))
    workspace = workspace_of(Object("can", Cylinder(0.05, 0.12), lying))
    hands = hands_behind(workspace, "can", workspace.start["can"], AHEAD, np.array([0.03]), highest)
    assert (next(hands, None) is not None) == touched
