"""Estimates of one look held against what was expected."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.perception.belief.belief import Belief, nearest_turn, tolerance, updated
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.evaluation import pose_error
from tamp.perception.rendering.surface import plain
from tamp.task import Box, Pose

pytest.importorskip("embreex", reason="the extra perception is not installed")

MODEL = object_model(plain(Box((0.16, 0.09, 0.05))))
HERE = Pose.from_rpy((0.1, 0.2, 0.025), (0.0, 0.0, 0.3))
UNSEEN = Estimate(None, 0.0)


def _after(expected: Estimate, found: Estimate, *, absent: bool = False) -> Estimate:
    return updated({"a": MODEL}, {"a": expected}, {"a": found}, {"a"} if absent else ())["a"]


def _moved(by: float) -> Pose:
    return Pose((0.1 + by, 0.2, 0.025), HERE.quat)


def test_what_is_seen_first_is_believed() -> None:
    assert _after(UNSEEN, Estimate(HERE, 0.4)) == Estimate(HERE, 0.4)
    assert _after(UNSEEN, UNSEEN) == UNSEEN


def test_an_estimate_that_is_confirmed_stays_as_it_is_and_is_as_sure_as_the_surer() -> None:
    assert _after(Estimate(HERE, 0.5), Estimate(_moved(0.001), 0.9)) == Estimate(HERE, 0.9)


def test_an_estimate_that_is_a_little_off_is_brought_up_to_date() -> None:
    assert _after(Estimate(HERE, 0.9), Estimate(_moved(0.008), 0.8)).pose == _moved(0.008)


def test_far_off_the_surer_is_believed_unless_it_is_seen_not_to_be_there() -> None:
    expected = Estimate(HERE, 0.9)
    assert _after(expected, Estimate(_moved(0.2), 0.5)).pose == HERE
    assert _after(expected, Estimate(_moved(0.2), 0.5), absent=True).pose == _moved(0.2)
    assert _after(expected, Estimate(_moved(0.2), 0.95)).pose == _moved(0.2)


def test_what_is_not_found_stays_unless_it_is_seen_not_to_be_there() -> None:
    kept = _after(Estimate(HERE, 0.8), UNSEEN)
    assert (kept.pose, kept.confidence) == (HERE, 0.4)
    assert _after(Estimate(HERE, 0.8), UNSEEN, absent=True) == UNSEEN


def test_an_uncertain_sight_moves_nothing_that_nothing_speaks_against() -> None:
    expected = Estimate(HERE, 0.9)
    assert _after(expected, Estimate(_moved(0.015), 0.1)) == expected
    assert _after(expected, Estimate(_moved(0.015), 0.1), absent=True).pose == _moved(0.015)


def test_where_a_plan_has_brought_an_object_it_is_rather_than_where_others_are_mistaken_for_it() -> None:
    there = Pose((0.1, -0.5, 0.025))
    brought = Belief({"a": Estimate(HERE, 0.99)}).expecting({"a": there}).estimates["a"]
    assert _after(brought, Estimate(HERE, 0.85)).pose == there
    assert _after(brought, Estimate(HERE, 0.85), absent=True).pose == HERE


def test_what_fingers_have_lost_is_where_it_is_found_and_not_where_it_was() -> None:
    there = Estimate(_moved(0.2), 0.8)
    belief = Belief({"a": Estimate(HERE, 1.0), "b": Estimate(HERE, 1.0)}).expecting({"a": HERE, "b": HERE}, ["a"])
    assert _after(belief.estimates["a"], there).pose == there.pose
    assert _after(belief.estimates["b"], there).pose == HERE
    assert belief.trusted().keys() == {"b"}


@given(st.floats(-0.004, 0.004), st.floats(-0.004, 0.004), st.sampled_from((0.0, math.pi)))
def test_a_turn_that_the_shape_cannot_show_is_undone(x: float, y: float, turn: float) -> None:
    seen = Pose((x, y, 0.0)) @ HERE @ Pose.from_rpy((0, 0, 0), (0.0, 0.0, turn))
    found = nearest_turn(MODEL, seen, HERE)
    assert pose_error(MODEL, found, HERE)[1] == pytest.approx(math.hypot(x, y), abs=2e-3)


@given(st.floats(0, 1), st.floats(0, 1))
def test_the_less_sure_the_more_is_tolerated(a: float, b: float) -> None:
    low, high = Estimate(HERE, min(a, b)), Estimate(HERE, max(a, b))
    assert tolerance(high, high) <= tolerance(low, high) <= 0.03 + 1e-12


def test_of_two_alike_each_keeps_its_name() -> None:
    there = Pose((0.1, -0.2, 0.025))
    expected = {"a": Estimate(HERE, 0.9), "b": Estimate(there, 0.9)}
    found = {"a": Estimate(there, 0.8), "b": Estimate(HERE, 0.8)}
    after = updated({"a": MODEL, "b": MODEL}, expected, found, ())
    assert (after["a"].pose, after["b"].pose) == (HERE, there)


def test_a_belief_expects_objects_where_a_plan_has_brought_them() -> None:
    belief = Belief({"a": Estimate(HERE, 0.9), "b": UNSEEN}).expecting({"a": _moved(0.1), "b": HERE})
    assert belief.poses == {"a": _moved(0.1)}
    assert belief.estimates["a"].confidence < 0.9, "nobody has seen it there"
    assert Belief({"a": Estimate(HERE, 0.9)}).expecting({"a": HERE}).trusted(0.9) == {"a": HERE}
