from __future__ import annotations

import numpy as np
import pytest

from tamp.streams.collisions import ARM_MARGIN, CONTACT_DEPTH
from tamp.streams.motion.lift import LIFTS, Reach, lifted
from tamp.streams.values import Grasp
from tamp.task import Box, Object, Pose
from tamp.world.kinematics.inverse import inverse
from tests.streams.tables import ToldContext, panda, workspace_of

LEANING = 0.44
"""From the vertical, towards +x [rad]."""
LEAF = Box((0.01, 0.12, 0.16))
UNDER = Object("under", LEAF, Pose.from_rpy((0.0, 0.0, 0.08), (0.0, LEANING, 0.0)))
OVER = Object("over", LEAF, UNDER.pose @ Pose((-0.022, 0.0, 0.0)))
AT_THE_TOP = Grasp(Pose.from_rpy((0.0, 0.0, 0.07), (np.pi, 0.0, np.pi / 2)), 0.01)


def way_off(workspace):
    """Where the object is on its way off, shape (n, 4, 4)."""
    context, start = ToldContext(workspace), workspace.start["under"]
    tool = start.pose.matrix @ AT_THE_TOP.T_object_tool.matrix
    for q in inverse(panda(), tool, context.rng, count=4):
        found = lifted(context, Reach("under", start, AT_THE_TOP, 0.02, q[None], ()))
        if found is not None:
            T_tool_object = AT_THE_TOP.T_object_tool.inverse().matrix
            return np.array([panda().forward(q) @ T_tool_object for q in found[1]])
    raise AssertionError(context.reasons)


def test_what_stands_free_is_lifted_straight_up():
    passed = way_off(workspace_of(UNDER))[:, :3, 3]
    assert np.allclose(passed[:, :2], passed[0, :2], atol=1e-3)
    assert passed[-1, 2] - passed[0, 2] == pytest.approx(LIFTS[0], abs=1e-3)


def test_what_another_leans_over_is_drawn_away_from_under_it():
    workspace = workspace_of(UNDER, OVER)
    over, tolerance = OVER.pose.matrix, CONTACT_DEPTH
    risen = UNDER.pose.matrix + np.outer([0, 0, 1, 0], [0, 0, 0, 0.05])
    assert workspace.world.overlap("under", risen, "over", over, tolerance=tolerance)
    passed = way_off(workspace)
    assert not any(workspace.world.overlap("under", T, "over", over, tolerance=tolerance) for T in passed)
    assert passed[-1, 0, 3] > passed[0, 0, 3] + 0.01


def test_what_grazes_its_neighbour_is_lifted_clear_of_it():
    """The way on begins there, and no motion begins in contact."""
    upright, tilt = Object("under", LEAF, Pose((0.0, 0.0, 0.08))), 0.001
    side, end = Box((0.02, 0.14, 0.3)), Box((0.06, 0.02, 0.3))
    walls = (
        Object("wall", side, Pose.from_rpy((0.0141, 0.0, 0.15), (0.0, -tilt, 0.0))),  # more in the way the higher up
        Object("opposite", side, Pose((-0.019, 0.0, 0.15))),
        *(Object(f"end_{y:+.3f}", end, Pose((0.0, y, 0.15))) for y in (-0.074, 0.074)),
    )
    workspace = workspace_of(upright, *walls)
    passed = way_off(workspace)
    assert workspace.world.separation("under", passed[0], "wall", walls[0].pose.matrix) < 0.0
    assert workspace.world.separation("under", passed[-1], "wall", walls[0].pose.matrix) > ARM_MARGIN
