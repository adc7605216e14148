from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.affordances.detour import detours, ends
from tamp.streams.affordances.slide_path import directions
from tamp.streams.values import Placement
from tamp.task import Box, Object, Pose
from tests.streams.tables import corners, workspace_of

FLAT = Object("flat", Box((0.17, 0.11, 0.045)), Pose((0.15, 0.0, 0.0225)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(FLAT)


def test_from_the_far_side_two_pushes_lead_to_edges_within_reach(workspace):
    start = workspace.start["flat"]
    among = list(directions(workspace, "flat", start))
    led = [end for end in ends(workspace, "flat", start) if any(detours(workspace, "flat", start, end, among))]
    assert {tuple(end.outward.round()) for end in led} >= {(0.0, 1.0), (0.0, -1.0)}


@settings(max_examples=20, deadline=None)
@given(x=st.floats(-0.3, 0.2), y=st.floats(-0.4, 0.4), yaw=st.floats(-np.pi, np.pi))
def test_two_pushes_end_where_they_shall_and_pass_over_the_table(workspace, x, y, yaw):
    start = Placement(Pose.from_rpy((x, y, 0.0225), (0.0, 0.0, yaw)), ("table",))
    table = workspace.task.table
    half = np.array(table.size) / 2
    for end in ends(workspace, "flat", start)[:4]:
        among = list(directions(workspace, "flat", start))
        for first, second in islice(detours(workspace, "flat", start, end, among), 4):
            assert np.allclose(second.end.pose.xyz, end.placement.pose.xyz, atol=1e-9)
            assert np.allclose(first.shift + second.shift, end.shift, atol=1e-9)
            assert second.shift @ end.outward > 0.0
            between = corners(workspace, "flat", first.end.pose)[:, :2] - table.center
            assert (np.abs(between) < half + 1e-9).all()
            # The second hand touches the object where the first has left it.
            moved = second.touch - np.array(first.end.pose.xyz[:2])
            assert float(np.linalg.norm(moved)) < 0.12
