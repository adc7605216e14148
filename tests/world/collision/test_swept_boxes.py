"""Boxes swept by the arm: whatever lies outside all of them is never met."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.task import Box, Object, Pose
from tamp.world.collision.swept_boxes import swept_boxes
from tamp.world.scene import Scene
from tests.streams.tables import panda, workspace_of

CUBE = Object("cube", Box((0.05, 0.05, 0.05)), Pose((0.2, 0.2, 0.025)))
ROD = Object("rod", Box((0.02, 0.2, 0.02)), Pose((0.2, -0.2, 0.01)))
T_TOOL_ROD = Pose((0.0, 0.05, 0.01)).matrix


@pytest.fixture(scope="module")
def world():
    return workspace_of(CUBE, ROD).world


def path(seed, length):
    rng = np.random.default_rng(seed)
    return np.clip(panda().home + length * rng.normal(size=(3, 7)), panda().lower, panda().upper)


@given(seed=st.integers(0, 10_000), xyz=st.tuples(*[st.floats(-0.6, 0.8)] * 3), holding=st.booleans())
@settings(max_examples=60, deadline=None)
def test_nothing_is_met_outside(world, seed, xyz, holding):
    points, pose = path(seed, 0.3), Pose(xyz)
    held = world.geometries["rod"].parts[0].vertices @ T_TOOL_ROD[:3, :3].T + T_TOOL_ROD[:3, 3]
    lower, upper = swept_boxes(panda(), points, 0.04, held if holding else None)
    low, high = np.array(xyz) - 0.025, np.array(xyz) + 0.025
    if ((lower < high) & (low < upper)).all(axis=1).any():
        return
    scene = Scene({"cube": pose.matrix}, opening=0.04)
    scene = scene.attached("rod", T_TOOL_ROD, 0.04) if holding else scene
    contact = world.checker(scene, margin=0.0).first_contact(points)
    assert contact is None or "cube" not in (contact.a, contact.b)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_the_tool_stays_inside_the_boxes_of_a_point_that_it_holds(seed):
    points = path(seed, 0.2)
    lower, upper = swept_boxes(panda(), points, 0.0, np.zeros((1, 3)))
    tools = np.array([panda().forward(q)[:3, 3] for q in points])
    assert (tools >= lower[-1] - 1e-9).all()
    assert (tools <= upper[-1] + 1e-9).all()
