from itertools import islice

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.poses import rotation, turned_about
from tamp.streams.rolling import ROLL, rolls

CUBE = np.array([[x, y, z] for x in (0.0, 0.1) for y in (0.0, 0.1) for z in (0.0, 0.1)])


@given(angle=st.floats(-np.pi, np.pi), count=st.integers(1, 100))
@settings(max_examples=30, deadline=None)
def test_what_rolls_stays_on_the_plane_and_turns_evenly(angle, count):
    outward = np.array([np.cos(angle), np.sin(angle)])
    *_, (T, touching) = islice(rolls(CUBE, np.eye(4), outward), count)
    world = CUBE @ T[:3, :3].T + T[:3, 3]
    assert abs(world[:, 2].min()) < 1e-9
    turn = rotation(np.array([-outward[1], outward[0], 0.0]), count * ROLL)
    np.testing.assert_allclose(T[:3, :3], turn, atol=1e-9)
    assert (world[:, :2] @ outward).min() - 1e-9 <= touching.min() <= touching.max()


def test_after_a_quarter_turn_a_cube_lies_beside_where_it_lay():
    *_, (T, touching) = islice(rolls(CUBE, np.eye(4), np.array([1.0, 0.0])), round(np.pi / 2 / ROLL))
    world = CUBE @ T[:3, :3].T + T[:3, 3]
    np.testing.assert_allclose(world.min(axis=0), (0.1, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(sorted(set(touching.round(6))), (0.1, 0.2), atol=1e-9)


def test_the_point_that_something_turns_about_stays():
    pivot, T = np.array([0.3, 0.2, 0.1]), np.eye(4)
    turned = turned_about(pivot, rotation(np.array([0.0, 0.0, 1.0]), 0.7), T)
    np.testing.assert_allclose(turned[:3, :3] @ pivot + turned[:3, 3], pivot)
