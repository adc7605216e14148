from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.affordances.friction_cones import in_equilibrium
from tamp.streams.affordances.stack_balance import (
    at_rest,
    balance_with,
    balance_without,
    learn_upset,
    needed_below,
    pile_of,
    tips_with,
)
from tamp.streams.values import Placement
from tamp.task import Box, Object, Pose
from tests.streams.tables import ToldContext, workspace_of

BLOCK = Object("block", Box((0.05, 0.05, 0.06)), Pose((0.0, 0.0, 0.03)))
PLANK = Object("plank", Box((0.3, 0.05, 0.02)), Pose((0.0, 0.0, 0.07)), mass=0.1)


def scales(*weights: tuple[float, float]):
    """A plank on a block, and on it weights, each by where along it and how heavy, called a, b, c; and placements."""
    named = [
        Object(name, Box((0.03, 0.03, 0.06)), Pose((x, 0.0, 0.11)), mass=mass)
        for name, (x, mass) in zip("abc", weights, strict=False)
    ]
    workspace = workspace_of(BLOCK, PLANK, *named)
    on = {"block": "table", "plank": "block"}
    places = {o.name: Placement(o.pose, (on.get(o.name, "plank"),)) for o in (BLOCK, PLANK, *named)}
    return replace(workspace, start=places), places


def facts(places):
    return tuple(("AtPose", name, place) for name, place in places.items())


@given(
    at=st.tuples(st.floats(-0.13, -0.03), st.floats(0.03, 0.13)),
    masses=st.tuples(st.floats(0.05, 1), st.floats(0.05, 1)),
)
@settings(max_examples=25, deadline=None)
def test_scales_balance_as_their_moments_say(at, masses):
    workspace, places = scales(*zip(at, masses, strict=True))
    outside = abs(sum(m * x for x, m in zip(at, masses, strict=True)) / (sum(masses) + 0.1)) - 0.025
    if abs(outside) > 0.001:
        assert at_rest(workspace, places) == (outside < 0)


def test_a_weight_tips_what_nothing_holds_down_on_the_other_side():
    workspace, places = scales((-0.1, 0.2), (0.1, 0.2))
    beside = Placement(Pose((0.1, 0.3, 0.03)), ("table",))
    alone = replace(workspace, start={**places, "b": beside, "a": beside})
    counterweighted = replace(workspace, start={**places, "b": beside})
    assert tips_with(alone, "a", places["a"]) and not tips_with(alone, "a", beside)
    assert not tips_with(replace(workspace, start={**places, "a": beside}), "a", places["a"])
    assert not tips_with(counterweighted, "b", places["b"])


def test_what_is_learnt_of_a_pile_holds_for_that_alone():
    workspace, places = scales((0.01, 0.05))
    others = facts({name: place for name, place in places.items() if name != "a"})
    context = ToldContext(workspace, fluents=others)
    beside = Placement(Pose((0.012, 0.0, 0.11)), ("plank",))
    assert any(True for _ in balance_with(context, "a", places["a"]))
    learn_upset(workspace, "a", places)
    assert not any(True for _ in balance_with(context, "a", places["a"]))
    assert any(True for _ in balance_with(context, "a", beside))


def test_what_is_learnt_of_taking_a_thing_says_nothing_of_putting_it_there():
    workspace, places = scales((0.01, 0.05))
    context = ToldContext(workspace, fluents=facts(places))
    assert any(True for _ in balance_without(context, "a", places["a"]))
    learn_upset(workspace, "a", places, put=False)
    assert not any(True for _ in balance_without(context, "a", places["a"]))
    assert any(True for _ in balance_with(context, "a", places["a"]))


def test_where_a_thing_is_taken_from_counts_though_all_else_stands_alike():
    """Asked first of a weight that never was in balance, then of the counterweight that keeps the other one up."""
    workspace, places = scales((-0.12, 1.0), (0.12, 1.0))
    context = ToldContext(workspace, fluents=facts(places))
    near = Placement(Pose((0.01, 0.0, 0.11)), ("plank",))
    assert any(True for _ in balance_without(context, "b", near))
    assert not any(True for _ in balance_without(context, "b", places["b"]))


@pytest.mark.parametrize(("mass", "stays"), [(1.0, False), (0.01, True)])
def test_a_counterweight_stays_where_the_rest_would_tip(mass, stays):
    workspace, places = scales((-0.12, mass), (0.12, mass))
    context = ToldContext(workspace, fluents=facts(places))
    assert bool(list(balance_without(context, "a", places["a"]))) == stays


@pytest.mark.parametrize(("height", "taken"), [(0.06, False), (0.006, True)])
def test_what_holds_others_up_by_a_little_may_be_taken_from_them(height, taken):
    """A counterweight on a plank that comes down to the table without it, from so high."""
    low = Object("block", Box((0.05, 0.05, height)), Pose((0.0, 0.0, height / 2)))
    plank = replace(PLANK, pose=Pose((0.0, 0.0, height + 0.01)))
    weights = [
        Object(name, Box((0.03, 0.03, 0.06)), Pose((x, 0.0, height + 0.05)), mass=0.2)
        for name, x in (("a", -0.1), ("b", 0.1))
    ]
    workspace = workspace_of(low, plank, *weights)
    on = {"block": "table", "plank": "block"}
    places = {o.name: Placement(o.pose, (on.get(o.name, "plank"),)) for o in (low, plank, *weights)}
    context = ToldContext(replace(workspace, start=places), fluents=facts(places))
    assert bool(list(balance_without(context, "a", places["a"]))) == taken


@pytest.mark.parametrize(("x", "stays"), [(0.12, False), (0.01, True)])
def test_what_is_set_on_a_plank_does_not_tip_it(x, stays):
    workspace, places = scales((x, 1.0))
    others = {name: place for name, place in places.items() if name != "a"}
    context = ToldContext(workspace, fluents=facts(others))
    assert bool(list(balance_with(context, "a", places["a"]))) == stays


def test_a_plank_on_two_blocks_bears_a_weight_between_them():
    workspace, places = scales((0.0, 2.0))
    other = Object("other", BLOCK.shape, Pose((0.12, 0.0, 0.03)))
    first = replace(BLOCK, pose=Pose((-0.12, 0.0, 0.03)))
    workspace = workspace_of(first, other, PLANK, workspace.task.object("a"))
    places |= {"block": Placement(first.pose, ("table",)), "other": Placement(other.pose, ("table",))}
    places |= {"plank": Placement(PLANK.pose, ("block", "other"))}
    assert at_rest(workspace, places)
    single = {**places, "plank": Placement(PLANK.pose, ("other",))}
    assert not at_rest(workspace, {name: place for name, place in single.items() if name != "block"})
    assert pile_of("a", places) == {"a", "plank", "block", "other"}


@pytest.mark.parametrize(("x", "needed"), [(0.0, ("q",)), (-0.1, ("p", "r")), (0.1, ("q", "r"))])
def test_a_plank_needs_no_more_blocks_than_hold_it_with_what_it_carries(x, needed):
    at = {"p": -0.1, "q": 0.0, "r": 0.1}
    blocks = [replace(BLOCK, name=name, pose=Pose((place, 0.0, 0.03))) for name, place in at.items()]
    weight = Object("weight", Box((0.03, 0.03, 0.06)), Pose((x, 0.0, 0.11)), mass=1.0)
    workspace = workspace_of(*blocks, PLANK, weight, on={"plank": ("p", "q", "r"), "weight": ("plank",)})
    assert needed_below(workspace, "plank", "pqr") == needed
    assert needed_below(workspace, "weight", ["plank"]) == ("plank",)
    assert needed_below(workspace, "plank", "q") == ("p", "r")


def test_a_part_of_the_scene_is_not_judged():
    workspace, places = scales((-0.12, 1.0), (0.12, 1.0))
    seen = {name: place for name, place in places.items() if name != "b"}
    assert list(balance_with(ToldContext(workspace, fluents=facts(seen)), "a", places["a"]))


@given(steepness=st.one_of(st.floats(0.3, 0.8), st.floats(1.25, 1.8)), friction=st.floats(0.3, 0.7))
@settings(max_examples=15, deadline=None)
def test_a_ladder_stays_just_where_friction_holds_it(steepness, friction):
    """At an angle t from the wall it stays where tan(t) <= 2 m / (1 - m n), with friction m below and n at the wall."""
    angle = np.arctan(steepness * 2 * friction / (1 - friction * friction**2))
    wall = Object("wall", Box((0.2, 0.3, 0.4)), Pose((0.1, 0.0, 0.2)), mass=50.0, friction=friction)
    x = -0.15 * np.sin(angle) - 0.005 * np.cos(angle)
    z = 0.15 * np.cos(angle) + 0.005 * np.sin(angle)
    pose = Pose((x, 0.0, z), (0.0, np.sin(angle / 2), 0.0, np.cos(angle / 2)))
    ladder = Object("ladder", Box((0.01, 0.08, 0.3)), pose, mass=0.2, friction=friction)
    places = {"wall": Placement(wall.pose, ("table",)), "ladder": Placement(pose, ("table",))}
    assert in_equilibrium(workspace_of(wall, ladder), places) == (steepness < 1.0)


@pytest.mark.parametrize(("along", "stands"), [(0.0, True), (0.02, True), (0.03, False), (0.1, False)])
def test_what_a_body_bears_may_shift_its_centre_of_mass(along, stands):
    places = {body.name: Placement(body.pose, ("table",)) for body in (BLOCK, PLANK)}
    borne = {"plank": np.array([along, 0.0, 0.08])}
    assert in_equilibrium(workspace_of(BLOCK, PLANK), places, centers=borne) == stands
