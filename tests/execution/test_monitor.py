import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.execution.monitor import Monitor, angle_between
from tamp.task import Pose

angles = st.floats(-math.pi, math.pi)


@given(a=angles, b=angles)
def test_the_angle_between_turns_about_one_axis_is_their_difference(a, b):
    difference = abs(math.remainder(a - b, 2 * math.pi))
    turned = (Pose.from_rpy((0, 0, 0), (0, 0, a)), Pose.from_rpy((0, 0, 0), (0, 0, b)))
    assert angle_between(*turned) == pytest.approx(difference, abs=1e-6)


def test_small_deviations_are_tolerated():
    expected = {"a": Pose((0, 0, 0)), "b": Pose((1, 0, 0))}
    assert Monitor().compare(expected, {"a": Pose((0.005, 0, 0)), "b": Pose((1, 0, 0))}, ["a"]) == ()


def test_deviations_say_what_happened_the_largest_first():
    expected = {"a": Pose(), "b": Pose((1, 0, 0)), "c": Pose()}
    actual = {"a": Pose((0.02, 0, 0)), "b": Pose((1, 0.05, 0)), "c": Pose.from_rpy((0, 0, 0), (0.5, 0, 0))}
    found = Monitor().compare(expected, actual, ["a"])
    assert [(d.object, d.kind) for d in found] == [("b", "disturbed"), ("a", "misplaced"), ("c", "disturbed")]
    assert str(found[0]) == "b disturbed: off by 50.0 mm and 0.00 rad"


def test_a_held_object_may_slip_a_little():
    assert Monitor().slipped("a", Pose(), Pose((0.01, 0, 0))) is None
    slipped = Monitor().slipped("a", Pose(), Pose((0.03, 0, 0)))
    assert slipped is not None and slipped.kind == "slipped"
