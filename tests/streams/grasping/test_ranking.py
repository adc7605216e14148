from __future__ import annotations

import math

import numpy as np
import pytest

from tamp.streams.grasping.ranking import SWAPPED, untwisted
from tamp.streams.hand.candidates import Pinches
from tamp.streams.values import CLEARANCE
from tamp.task import Pose
from tests.streams.tables import panda

HOME = panda().forward(panda().home)


def from_above(workspace, yaw):
    """A pinch of the red box from above by a hand turned by `yaw` from home, as the arm reaches there."""
    start = workspace.start["red"].pose
    base = np.array(panda().spec.T_world_base.xyz)
    swing = math.atan2(start.xyz[1] - base[1], start.xyz[0] - base[0])
    R = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, swing + yaw)).matrix @ HOME
    R[:3, 3] = start.xyz
    return Pinches(
        np.linalg.inv(start.matrix)[None] @ R, np.array([0.05]), np.array([0.012]), np.zeros(1), np.array([CLEARANCE])
    )


@pytest.mark.parametrize("yaw", [2.9, -2.5, 2.2])
def test_fingers_swap_sides_where_the_wrist_has_to_turn_much_less_then(table, yaw):
    pinches = from_above(table, yaw)
    found = untwisted(table, pinches, [table.start["red"]]).T_object_tool
    np.testing.assert_allclose(found[0, :3, 2:], pinches.T_object_tool[0, :3, 2:], atol=1e-12)  # as it came, from above
    np.testing.assert_allclose(found[0, :3, :2], -pinches.T_object_tool[0, :3, :2], atol=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -1.5, (math.pi - SWAPPED) / 2])
def test_they_stay_where_that_gains_little(table, yaw):
    pinches = from_above(table, yaw)
    found = untwisted(table, pinches, [table.start["red"]]).T_object_tool
    np.testing.assert_array_equal(found, pinches.T_object_tool)
