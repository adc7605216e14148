from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import ConvexHull, QhullError

from tamp.checking.physics import equilibrium as statics


def touching(seed, count, tilt):
    """Contacts (points, normals) under a body about the origin."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.1, 0.1, (count, 3)) * (1.0, 1.0, 0.3)
    normals = rng.normal((0.0, 0.0, 1.0), tilt, (count, 3))
    return points, normals / np.linalg.norm(normals, axis=1)[:, None]


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 120), st.sampled_from([0.1, 0.5, 2.0]), st.floats(-0.15, 0.15))
def test_pushes_that_are_asked_bit_by_bit_balance_as_well_as_all_of_them(seed, count, tilt, x):
    points, normals = touching(seed, count, tilt)
    wrenches = statics.wrenches(points, normals, np.full(count, 0.5))
    target = np.array([0.0, 0.0, 1.0, 0.0, -x / statics.SCALE, 0.0])
    whole, _ = statics._program(wrenches, target)
    assert statics._shortfall(wrenches, (x, 0.0)) == pytest.approx(whole, abs=1e-7)


def test_level_contacts_hold_what_their_polygon_holds():
    points = np.array([[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]])
    normals, friction = np.tile([0.0, 0.0, 1.0], (4, 1)), np.full(4, 0.5)
    assert statics.balance(points, normals, friction, np.array([0.05, 0.0, 0.1]), 0.01) >= 0.01
    assert statics.balance(points, normals, friction, np.array([0.13, 0.0, 0.1]), 0.01) == pytest.approx(-0.03)


@settings(deadline=None)
@given(arrays(float, (12, 2), elements=st.floats(-1.0, 1.0)), arrays(float, (5, 2), elements=st.floats(-2.0, 2.0)))
def test_places_are_inside_or_outside_a_polygon_by_their_distance_from_its_edges(points, places):
    try:
        edges = ConvexHull(points).equations
    except QhullError:
        return  # they lie on a line
    exact = -(places @ edges[:, :2].T + edges[:, 2]).max(axis=1)
    found = statics.inside(points, places)
    assert np.all(found < exact + 0.02)
    assert np.all((exact < 0.0) | (found > exact - 0.02))


def test_what_touches_nothing_does_not_rest():
    assert statics.balance(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(3), 0.0) == -np.inf


@given(st.floats(0.02, 0.05), st.floats(0.0001, 0.002))
def test_a_slot_holds_what_reaches_as_far_into_it_as_weight_can_press_and_nothing_that_barely_does(deep, shallow):
    def held(depth):
        sides = [(x, y, 0.0) for y in (-0.02, 0.02) for x in (0.0, -depth)]
        normals = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)] * 2)
        return statics.balance(np.array(sides), normals, np.full(4, 0.5), np.array([0.1, 0.0, 0.0]), 0.001)

    assert held(deep) >= 0.001 > held(shallow)


@pytest.mark.parametrize("share, rests", [(1.005, True), (0.98, False)])
def test_what_has_slid_to_rest_stays_where_friction_just_holds_it(share, rests):
    """A ladder against a wall, both as rough: it slides where the tangent of its slope is below (1 - mu^2) / (2 mu)."""
    mu = 0.25
    run, rise = 0.2, share * 0.2 * (1 - mu**2) / (2 * mu)
    points = np.array([(x, y, z) for x, z in ((0.0, 0.0), (run, rise)) for y in (-0.05, 0.05)])
    normals = np.array([(0.0, 0.0, 1.0)] * 2 + [(-1.0, 0.0, 0.0)] * 2)
    center = np.array([run / 2, 0.0, rise / 2])
    assert (statics.balance(points, normals, np.full(4, mu), center, 0.001) >= 0.001) == rests


def facing(*degrees):
    """Level unit normals, each so many degrees off straight ahead along x."""
    angle = np.radians(degrees)
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)


AHEAD = np.array([1.0, 0.0, 0.0])
TWO = np.array([[-0.05, -0.04, 0.0], [-0.05, 0.04, 0.0]])


@pytest.mark.parametrize(("friction", "slant", "held"), [(0.3, 20, False), (0.3, 14, True), (0.15, 10, False)])
def test_a_flank_is_pushed_as_far_aslant_as_friction_holds(friction, slant, held):
    assert statics.holds_ahead(TWO, facing(slant, slant), friction, AHEAD) == held
    assert statics.holds_ahead(np.zeros((1, 3)), facing(-slant), friction, AHEAD) == held


def test_fingers_on_both_sides_of_what_is_round_hold_it_between_them_without_friction():
    assert statics.holds_ahead(TWO, facing(20, -20), 0.01, AHEAD)
    assert not statics.holds_ahead(TWO, facing(20, 5), 0.01, AHEAD)
    beside = TWO + np.array([0.0, 0.03, 0.0])  # their pushes meet beside the centre of mass, and turn it
    assert not statics.holds_ahead(beside, facing(20, -20), 0.01, AHEAD)


def test_a_flank_that_leans_is_pushed_straight_ahead_all_the_same():
    down = np.array([[np.cos(0.8), 0.0, -np.sin(0.8)]])
    assert statics.holds_ahead(np.zeros((1, 3)), down, 0.1, AHEAD)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 30))
def test_a_hull_reaches_as_far_ahead_as_its_edges_let_it(seed, count):
    rng = np.random.default_rng(seed)
    points, angle = rng.uniform(-1.0, 1.0, (count, 2)), rng.uniform(0.0, 2 * np.pi)
    ahead, hull = np.array([np.cos(angle), np.sin(angle)]), ConvexHull(points)
    center = points.mean(axis=0)  # inside
    rates, room = hull.equations[:, :2] @ ahead, -(hull.equations[:, :2] @ center + hull.equations[:, 2])
    assert statics.reach(points, center, ahead) == pytest.approx((room / rates)[rates > 0.0].min(), abs=0.01)
    assert statics.reach(points, center + 9.0 * np.array([-ahead[1], ahead[0]]), ahead) == -np.inf
