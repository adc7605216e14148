import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.streams.midtable import midtable, moved
from tamp.streams.tilting import tilts
from tamp.streams.values import Placement
from tamp.task import Box, Object, Pose
from tests.streams.tables import workspace_of

BOOK = Object("book", Box((0.15, 0.20, 0.03)), Pose.from_rpy((0.1, 0.25, 0.016), (0.0, 0.0, 0.0)))
FLAT = Placement(BOOK.pose, ("table",))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOOK)


def elsewhere(placement, x, y, angle):
    moved = Pose.from_rpy((x, y, 0.0), (0.0, 0.0, angle)) @ placement.pose
    return Placement(moved, placement.on)


@given(
    st.floats(-0.3, 0.3),
    st.floats(-0.3, 0.3),
    st.floats(-3.0, 3.0),
    st.sampled_from([0.0, np.pi / 2, np.pi]),
)
def test_all_places_on_the_table_have_one_in_its_middle(workspace, x, y, angle, roll):
    placement = Placement(Pose.from_rpy((0.0, 0.0, 0.05), (roll, 0.0, 0.0)), ("table",))
    middle = midtable(workspace, placement)
    other = midtable(workspace, elsewhere(placement, x, y, angle))
    np.testing.assert_allclose(other.pose.matrix, middle.pose.matrix, atol=1e-8)
    np.testing.assert_allclose(middle.pose.matrix[2], placement.pose.matrix[2], atol=1e-8)
    assert middle.pose.xyz[:2] == workspace.task.table.center


def test_a_fall_is_moved_as_a_whole_and_ends_at_the_placement(workspace):
    there = elsewhere(FLAT, 0.2, -0.1, 1.0)
    fall = tilts(workspace, "book", midtable(workspace, FLAT))[0].fall
    found = moved(fall, there)
    assert found[-1] == there.pose
    for pose, before in zip(found, fall, strict=True):
        step, meant = found[-1].inverse() @ pose, fall[-1].inverse() @ before
        np.testing.assert_allclose(step.matrix, meant.matrix, atol=1e-8)
