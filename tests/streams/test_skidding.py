import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.streams.skidding import FARTHEST, aimed, friction_beneath, skid
from tamp.streams.tilting import tilts
from tamp.streams.values import Placement
from tamp.task import At, Box, Object, Pose
from tests.streams.tables import workspace_of

BOOK = Object("book", Box((0.16, 0.12, 0.03)), Pose((0.1, 0.3, 0.015)), At(Pose((0.1, -0.2, 0.1))))
SMOOTH = Object("smooth", Box((0.2, 0.2, 0.02)), Pose((0.1, 0.0, 0.01)), friction=0.2)

# A board, half as long and half as thick, that falls by an angle.
boards = st.tuples(st.floats(0.03, 0.15), st.floats(0.005, 0.03), st.floats(0.1, 1.0)).filter(
    lambda board: lever(*board)[0] > 0.005
)


def lever(length, thickness, angle):
    """From the edge of a tilted board to its middle."""
    c, s = math.cos(angle), math.sin(angle)
    return length * c - thickness * s, length * s + thickness * c


def skid_of(board, friction):
    length, thickness, angle = board
    return skid(lever(*board), (length**2 + thickness**2) / 3, angle, friction)


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOOK, SMOOTH)


@given(board=boards)
def test_on_ice_the_middle_falls_straight_down(board):
    assert skid_of(board, 0.0) == pytest.approx(board[0] - lever(*board)[0], abs=3e-3)


@given(board=boards)
def test_an_edge_on_something_rough_stays(board):
    assert abs(skid_of(board, 20.0)) < 1e-3


@given(board=boards, friction=st.floats(0.0, 1.0))
def test_no_edge_skids_farther_than_on_ice(board, friction):
    assert skid_of(board, friction) < skid_of(board, 0.0) + 1e-3


def test_the_smoothest_of_what_it_lies_on_counts(workspace):
    at = BOOK.goal.pose
    assert friction_beneath(workspace, "book", Placement(at, ("table",))) == pytest.approx(0.5)
    assert friction_beneath(workspace, "book", Placement(at, ("smooth", "table"))) == pytest.approx(0.1)


def test_what_skids_is_let_go_on_the_side_that_is_up_and_lands_at_its_placement(workspace):
    place = Placement(BOOK.goal.pose, ("smooth",))
    shifted = []
    for tilt in tilts(workspace, "book", place):
        found = aimed(workspace, "book", place, tilt.fall)
        shifts = np.array([np.subtract(to.xyz, by.xyz) for to, by in zip(found, tilt.fall, strict=True)])
        assert [pose.quat for pose in found] == [pose.quat for pose in tilt.fall]
        assert (np.linalg.norm(shifts, axis=1) <= FARTHEST + 1e-9).all()
        assert np.allclose(shifts[-1], 0.0)
        rising = -tilt.fall[0].matrix[:2, 2]
        assert shifts[0][:2] @ rising >= 0.0
        shifted.append(np.linalg.norm(shifts[0]) > 2e-3)
    assert sum(shifted) > len(shifted) / 2
