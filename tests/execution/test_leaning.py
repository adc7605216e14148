import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.execution.leaning import leaning
from tamp.execution.simulator import Touch
from tamp.task import Box, Object, Pose

BOOK = Object("book", Box((0.03, 0.2, 0.25)), Pose())
WALL = Object("wall", Box((0.05, 0.2, 0.2)), Pose())
UPRIGHT = 0.2


def scene(tilt, yaw=0.0, force=1.0):
    """A book that stands on its lower edge, tilted, and touches a wall with its upper one; and their touches."""
    reach = 0.125 * math.sin(tilt) + 0.015 * math.cos(tilt)
    height = 0.125 * math.cos(tilt) + 0.015 * math.sin(tilt)
    turn = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw))
    wall = turn @ Pose((reach + 0.025, 0.0, 0.1))
    poses = {"book": turn @ Pose.from_rpy((0.0, 0.0, height), (0.0, tilt, 0.0)), "wall": wall}
    foot = (turn @ Pose((0.015 * math.cos(tilt) - 0.125 * math.sin(tilt), 0.0, 0.0))).xyz
    top = (turn @ Pose((reach, 0.0, 2 * height))).xyz
    normal = (turn @ Pose((-1.0, 0.0, 0.0))).xyz
    carried = Touch("table", "book", (0.0, 0.0, -1.0), 0.0, 1.0, foot)
    return poses, [carried, Touch("book", "wall", normal, 0.0, force, top)]


def leans(poses, touches):
    return sorted(leaning((BOOK, WALL), poses, touches, UPRIGHT))


@given(tilt=st.floats(0.2, 1.0), yaw=st.floats(-3.1, 3.1))
def test_what_would_tip_over_leans_on_what_pushes_it_back_wherever_that_is(tilt, yaw):
    assert leans(*scene(tilt, yaw)) == [("book", "wall")]


@given(yaw=st.floats(-3.1, 3.1))
def test_what_stands_by_itself_leans_on_nothing_it_touches(yaw):
    poses, touches = scene(0.3, yaw)
    assert leans({**poses, "book": Pose((0.0, 0.0, 0.125))}, touches) == []


def test_it_does_not_lean_on_what_pushes_it_on_or_does_not_push_at_all():
    poses, (foot, against) = scene(0.5)
    behind = Touch("book", "wall", (1.0, 0.0, 0.0), 0.0, 1.0, against.point)
    assert leans(poses, [foot, behind]) == []
    assert leans(*scene(0.5, force=0.0)) == []


def test_either_body_of_a_touch_may_be_named_first():
    poses, (foot, against) = scene(0.5)
    x, y, z = against.normal
    assert leans(poses, [foot, Touch("wall", "book", (-x, -y, -z), 0.0, 1.0, against.point)]) == [("book", "wall")]


@pytest.mark.parametrize("touches", [[], [Touch("book", "wall", (-1.0, 0.0, 0.0), 0.0, 1.0, (0.1, 0.0, 0.1))]])
def test_what_nothing_carries_leans_on_nothing(touches):
    assert leans(scene(0.5)[0], touches) == []


def test_of_two_that_push_each_other_the_one_that_is_farther_from_standing_leans():
    poses, touches = scene(0.5)
    steeper = scene(0.2)[0]["book"].xyz[2]
    other = Object("other", BOOK.shape, Pose())
    x = touches[1].point[0] + 0.1
    poses = {"book": poses["book"], "other": Pose.from_rpy((x, 0.0, steeper), (0.0, -0.2, 0.0))}
    foot = Touch("table", "other", (0.0, 0.0, -1.0), 0.0, 1.0, (x + 0.01, 0.0, 0.0))
    against = Touch("book", "other", (-1.0, 0.0, 0.0), 0.0, 1.0, touches[1].point)
    assert list(leaning((BOOK, other), poses, [touches[0], foot, against], UPRIGHT)) == [("book", "other")]
