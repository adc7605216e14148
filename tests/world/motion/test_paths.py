from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.world.motion.paths import densify, deviation, length, shortcut, without_duplicates

coordinates = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3)
paths = st.lists(coordinates, min_size=1, max_size=8).map(np.array)


class Wall:
    """A disc round the origin of the first two coordinates is blocked."""

    def __init__(self, radius=1.0):
        self.radius = radius

    def free(self, q):
        return bool(np.hypot(q[0], q[1]) > self.radius)

    def edge_free(self, q0, q1, resolution=0.05):
        count = max(1, int(np.ceil(np.linalg.norm(q1 - q0) / resolution)))
        return all(self.free(q0 + k / count * (q1 - q0)) for k in range(count + 1))

    def contact(self, q):
        raise AssertionError("paths ask only about edges")


@given(paths)
def test_densified_paths_keep_waypoints_and_step(path):
    dense = densify(path, 0.1)
    assert np.linalg.norm(np.diff(dense, axis=0), axis=1).max(initial=0.0) <= 0.1 + 1e-6
    assert deviation(dense, path).max() < 1e-6
    assert all((dense == waypoint).all(axis=1).any() for waypoint in path)


@given(paths)
def test_without_duplicates_keeps_the_ends_and_the_curve(path):
    distinct = without_duplicates(path)
    assert (distinct[0] == path[0]).all()
    assert np.linalg.norm(distinct[-1] - path[-1]) <= 1e-6
    assert (np.linalg.norm(np.diff(distinct, axis=0), axis=1) > 1e-6).all()
    assert deviation(path, distinct).max() <= 2e-6


def test_a_path_of_no_length_becomes_one_waypoint():
    assert without_duplicates(np.ones((4, 3))).shape == (1, 3)


def test_the_last_waypoint_is_kept_where_its_neighbour_is_dropped():
    path = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0 + 1e-9, 0.0, 0.0]])
    assert without_duplicates(path).tolist() == [path[0].tolist(), path[2].tolist()]


def test_deviation_of_points_beside_a_polyline():
    path = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    points = np.array([[0.5, 0.3, 0.0], [2.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
    assert deviation(points, path) == pytest.approx([0.3, 1.0, 0.0])


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_shortcuts_stay_free_and_never_lengthen(seed):
    angles = np.linspace(0.0, np.pi, 9)
    detour = np.stack([2.5 * np.cos(angles), 2.5 * np.sin(angles), np.zeros(9)], axis=1)
    shorter = shortcut(detour, Wall(), np.random.default_rng(seed))
    assert length(shorter) <= length(detour)
    assert (shorter[[0, -1]] == detour[[0, -1]]).all()
    # Parts of tested edges: between two tests a chord of 0.05 may dip into the disc by its sagitta.
    dip = 1.0 - np.sqrt(1.0 - 0.025**2)
    assert all(Wall(1.0 - dip).edge_free(a, b, 0.05) for a, b in pairwise(shorter))
    assert (shorter == shortcut(detour, Wall(), np.random.default_rng(seed))).all()


def test_a_needless_detour_becomes_one_edge():
    path = np.array([[2.0, 0.0, 0.0], [2.0, 2.0, 1.0], [2.5, 0.0, 0.0]])
    assert len(shortcut(path, Wall(), np.random.default_rng(0))) == 2
