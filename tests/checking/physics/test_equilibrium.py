from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
