from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.task import Box
from tamp.task.mesh.parts import Part, parts
from tamp.world.geometry.convex_union import contacts, crossed, overlap, relative, separation, solid

BOX = solid(parts(Box((0.1, 0.1, 0.1))))


def shifted(x, y=0.0, z=0.0):
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def open_box():
    """Four walls and a floor, 10 cm wide, 1 cm thick."""
    walls = [
        ((0.1, 0.1, 0.01), (0, 0, 0.005)),
        *(((0.01, 0.1, 0.1), (x, 0, 0.05)) for x in (-0.045, 0.045)),
        *(((0.1, 0.01, 0.1), (0, y, 0.05)) for y in (-0.045, 0.045)),
    ]
    found = []
    for size, center in walls:
        (part,) = parts(Box(size))
        found.append(Part(part.vertices + np.array(center), part.faces))
    return solid(found)


HOLLOW = open_box()


def random_pose(rng, reach):
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    T = np.eye(4)
    T[:3, :3] = Q * np.sign(np.linalg.det(Q))
    T[:3, 3] = rng.uniform(-reach, reach, 3)
    return T


@pytest.mark.parametrize("gap", [-0.01, -0.004, -0.002, 0.001, 0.004, 0.02])
@pytest.mark.parametrize("margin", [-0.003, 0.0, 0.003])
def test_a_margin_tolerates_or_demands_as_much(gap, margin):
    T = shifted(0.1 + gap, 0.001, 0.002)
    assert overlap(BOX, BOX, T, margin) == (gap <= margin)
    assert separation(BOX, BOX, T) == pytest.approx(gap, abs=1e-6)


def test_something_fits_into_a_hollow():
    small = solid(parts(Box((0.05, 0.05, 0.05))))
    inside = shifted(0, 0, 0.06)
    assert not overlap(HOLLOW, small, inside, 0.003)
    assert separation(HOLLOW, small, inside) == pytest.approx(0.015, abs=1e-6)
    assert overlap(HOLLOW, small, shifted(0.02, 0, 0.06), 0.0)
    assert overlap(small, HOLLOW, np.linalg.inv(shifted(0.02, 0, 0.06)), 0.0)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([-0.003, 0.0, 0.004]))
def test_overlap_agrees_with_separation_and_both_are_symmetric(seed, margin):
    rng = np.random.default_rng(seed)
    T = random_pose(rng, 0.12)
    for a, b in ((HOLLOW, HOLLOW), (HOLLOW, BOX), (BOX, HOLLOW)):
        gap = separation(a, b, T)
        if abs(gap - margin) > 1e-5 and not (gap < 0 and margin < 0):
            assert overlap(a, b, T, margin) == (gap < margin)
        assert separation(b, a, relative(T, np.eye(4))) == pytest.approx(gap, abs=1e-5)


@pytest.mark.parametrize("gap", [-0.002, 0.0005, 0.002])
def test_contacts_are_where_two_solids_nearly_touch_and_their_normals_point_to_the_first(gap):
    board = solid(parts(Box((0.3, 0.3, 0.02))))
    points, normals = contacts(BOX, board, shifted(0.0, z=-0.06 - gap), 0.003)
    assert points.shape == normals.shape == (1, 3)
    assert points[0, 2] == pytest.approx(-0.05 - gap, abs=1e-6)
    assert normals[0] == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)


def test_there_are_no_contacts_farther_apart_than_the_gap():
    points, normals = contacts(BOX, BOX, shifted(0.2), 0.003)
    assert len(points) == len(normals) == 0


@pytest.mark.parametrize(("depth", "across"), [(0.004, False), (0.0055, True), (0.009, True)])
def test_thin_parts_are_crossed_by_a_quarter_of_both_and_the_first_part_to_be_is_enough(depth, across):
    """Walls of 1 cm and a slab as thick: 5 mm, of which the deepest they can be in each other is 1 cm."""
    (part,) = parts(Box((0.01, 0.05, 0.05)))
    slab = solid([part, Part(part.vertices + np.array([0.0, 0.0, 0.3]), part.faces)])
    T = shifted(0.045 - 0.01 + depth, 0.0, 0.05)
    assert crossed(HOLLOW, slab, T) == crossed(slab, HOLLOW, np.linalg.inv(T)) == across


def test_what_is_not_thin_may_be_deep_before_it_is_crossed():
    assert not crossed(BOX, BOX, shifted(0.06))
    assert crossed(BOX, BOX, shifted(0.04))
