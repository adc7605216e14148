import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.surfaces import half_spaces, surface_points, typical_points
from tamp.task import Box
from tamp.task.mesh import Part, parts

sides = st.floats(0.01, 0.2)


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
