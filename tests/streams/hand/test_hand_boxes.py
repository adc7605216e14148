from __future__ import annotations

import numpy as np
import pytest

from tamp.streams.hand.hand_boxes import HandBoxes, hand_boxes, lowest_point, points_hit
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


def test_upright_over_the_table_the_fingertips_are_lowest(hand):
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[2, 3] = 0.1
    tip = hand.upper[0, :, 2].max()
    assert lowest_point(hand, np.array([0.05]), T[None])[0] == pytest.approx(0.1 - tip)
