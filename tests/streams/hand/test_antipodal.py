from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.hand.antipodal import antipodal_contacts
from tamp.streams.surfaces import surface_points, typical_points
from tamp.task import Box, Cylinder
from tamp.task.mesh.parts import Part, parts
from tamp.world.geometry.half_spaces import half_spaces

sides = st.floats(0.01, 0.2)


def contacts_of(pieces, max_width=0.078, seed=0):
    rng = np.random.default_rng(seed)
    surface = surface_points(pieces, 200, rng)
    return antipodal_contacts(pieces, surface, max_width=max_width, friction_angle=0.35, rng=rng)


def depth_outside(piece, points):
    A, b = half_spaces(piece)
    return (points @ A.T - b).max(axis=1)


@given(size=st.tuples(sides, sides, sides), seed=st.integers(0, 100))
@settings(max_examples=30, deadline=None)
def test_both_contacts_lie_on_the_box_and_fit_between_the_pads(size, seed):
    (piece,) = parts(Box(size))
    found = contacts_of([piece], seed=seed)
    for sign in (-1, 1):
        ends = found.centers + sign * 0.5 * found.widths[:, None] * found.axes
        assert np.abs(depth_outside(piece, ends)).max(initial=0) < 1e-7
    assert (found.widths <= 0.078).all()
    assert (found.slants <= 0.35).all()
    assert len(found.widths) > 0 or min(size) > 0.07


def test_a_box_wider_than_the_stroke_in_every_direction_has_no_contacts():
    assert len(contacts_of(parts(Box((0.1, 0.1, 0.1)))).widths) == 0


def test_a_cylinder_is_held_across_its_diameter_or_along_its_height():
    found = contacts_of(parts(Cylinder(0.03, 0.05)))
    across = np.abs(found.axes[:, 2]) < 0.4
    assert across.any()
    assert (~across).any()
    assert np.median(found.widths[across]) == pytest.approx(0.06, abs=0.003)


@pytest.mark.parametrize("slant", [0.25, 0.3, 0.34])
def test_faces_that_taper_are_pinched_along_the_line_that_meets_both_alike(slant):
    """Both normals must lie within the friction cone of the line: 0.35 rad, so it may be off by 0.35 less the slant."""
    top, bottom, height = 0.03, 0.03 + 2 * 0.05 * np.tan(slant), 0.05
    corners = [
        (sx * w / 2, sy * 0.06, z) for w, z in ((top, height), (bottom, 0.0)) for sx in (1, -1) for sy in (1, -1)
    ]
    hull = trimesh.convex.convex_hull(np.array(corners))
    taper = Part(np.array(hull.vertices), np.array(hull.faces))
    for seed in range(5):
        level = np.abs(contacts_of([taper], seed=seed).axes[:, 0]) > np.cos(0.1)
        assert level.sum() > 10


def test_a_hollow_ring_offers_its_wall_and_its_outer_width():
    walls = [((0.028, 0, 0), (0.004, 0.06, 0.05)), ((-0.028, 0, 0), (0.004, 0.06, 0.05))]
    walls += [((0, 0.028, 0), (0.052, 0.004, 0.05)), ((0, -0.028, 0), (0.052, 0.004, 0.05))]
    pieces = []
    for center, size in walls:
        (piece,) = parts(Box(size))
        pieces.append(Part(piece.vertices + np.array(center), piece.faces))
    widths = contacts_of(pieces).widths
    assert (np.abs(widths - 0.004) < 0.001).any()
    assert (np.abs(widths - 0.06) < 0.002).any()


def test_the_same_seed_gives_the_same_contacts():
    pieces = parts(Cylinder(0.03, 0.05))
    assert np.array_equal(contacts_of(pieces, seed=3).centers, contacts_of(pieces, seed=3).centers)


@given(size=st.tuples(sides, sides, sides), seed=st.integers(0, 100))
@settings(max_examples=30, deadline=None)
def test_surface_points_lie_on_a_box_and_their_area_adds_up(size, seed):
    (piece,) = parts(Box(size))
    surface = surface_points([piece], 100, np.random.default_rng(seed))
    A, b = half_spaces(piece)
    assert np.abs((surface.points @ A.T - b).max(axis=1)).max() < 1e-9
    x, y, z = size
    assert surface.area * 100 == pytest.approx(2 * (x * y + y * z + z * x))


def test_a_box_has_six_planes_however_its_sides_are_triangulated():
    (piece,) = parts(Box((0.1, 0.2, 0.3)))
    assert len(piece.faces) == 12
    A, b = half_spaces(piece)
    assert A.shape == (6, 3)
    assert sorted(b) == pytest.approx([0.05, 0.05, 0.1, 0.1, 0.15, 0.15])


def test_points_inside_another_part_are_hidden():
    (piece,) = parts(Box((0.1, 0.1, 0.1)))
    shifted = Part(piece.vertices + np.array([0.05, 0.0, 0.0]), piece.faces)
    points = surface_points([piece, shifted], 500, np.random.default_rng(0)).points
    within = (np.abs(points[:, 1:]) < 0.049).all(axis=1)
    inside_one, inside_other = (within & (np.abs(points[:, 0] - x) < 0.049) for x in (0.0, 0.05))
    assert not (inside_one | inside_other).any()


def test_typical_points_are_the_same_for_all():
    pieces = tuple(parts(Box((0.1, 0.1, 0.1))))
    assert typical_points(pieces) is typical_points(pieces)
