from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tamp.streams.hand.hand_boxes import HandBoxes, clear_of_slab, hand_boxes, points_hit
from tamp.task import load_robot
from tamp.world.robot.model import robot_model


@pytest.fixture(scope="module")
def hand() -> HandBoxes:
    return hand_boxes(robot_model(load_robot("panda")))


def test_the_fingers_leave_room_for_what_is_between_them(hand):
    between = np.array([[0.0, y, 0.0] for y in (-0.02, 0.0, 0.02)])
    assert points_hit(hand, np.array([0.05, 0.03]), np.stack([np.eye(4)] * 2), between).tolist() == [False, True]


def test_the_palm_is_behind_the_fingers(hand):
    assert points_hit(hand, np.array([0.05]), np.eye(4)[None], np.array([[0.0, 0.0, -0.06]]))[0]
    assert not points_hit(hand, np.array([0.05]), np.eye(4)[None], np.array([[0.0, 0.0, 0.03]]))[0]


EVERYWHERE = np.array([-1.0, -1.0]), np.array([1.0, 1.0])


def test_upright_over_the_table_the_fingertips_are_lowest(hand):
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[2, 3] = 0.1
    tip, opening = hand.upper[0, :, 2].max(), np.array([0.05])
    for gap, clear in ((0.1 - tip - 1e-6, True), (0.1 - tip + 1e-6, False)):
        assert clear_of_slab(hand, opening, np.eye(4), T[None], EVERYWHERE, gap).tolist() == [clear]


@given(seed=st.integers(0, 2**32 - 1), at=st.tuples(*[st.floats(-0.3, 0.3)] * 3), opening=st.floats(0.0, 0.08))
@settings(max_examples=50, deadline=None)
def test_a_hand_is_clear_of_a_table_just_where_the_corners_of_each_box_are(hand, seed, at, opening):
    """Above it, or, with the tool beside it, all of a box on the outer side of one of its edges."""
    turn, T_world, T_tool = Rotation.random(random_state=seed).as_matrix(), np.eye(4), np.eye(4)
    T_world[:3, :3], T_tool[:3, 3] = turn, at
    lower, upper = (corner[0] for corner in hand.opened(np.array([opening])))
    side, gap = 0.1, 0.002
    corners = [
        (np.array(list(itertools.product(*zip(low, high, strict=True)))) + at) @ turn.T
        for low, high in zip(lower, upper, strict=True)
    ]
    beside = (np.abs(turn @ at)[:2] > side).any()
    clear = all(
        (box[:, 2] > gap).all() or (beside and any((sign * box[:, :2] > side + gap).all(0).any() for sign in (-1, 1)))
        for box in corners
    )
    slab = np.full(2, -side), np.full(2, side)
    assert clear_of_slab(hand, np.array([opening]), T_world, T_tool[None], slab, gap).tolist() == [clear]
