"""The space that an object takes up: by its convex parts where they are known, else behind its points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.estimation.models.occupancy import INSIDE, Occupancy, occupancy_of_parts, shared
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box
from tamp.task.mesh.parts import Part, convex_hull
from tamp.world.geometry.half_spaces import half_spaces

pytest.importorskip("embreex", reason="the extra perception is not installed")

WALL, DEEP, WIDE = 0.004, 0.16, 0.05
FILLED = plain(Box((0.2, WIDE + 2 * WALL, DEEP)))
"""A holder as a scanner sees it: the hollow between its walls is filled."""


def _box(size: tuple[float, float, float], middle: tuple[float, float, float]) -> Part:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return convex_hull(corners * size + middle)


WALLS = (
    _box((0.2, WALL, DEEP), (0.0, (WIDE + WALL) / 2, 0.0)),
    _box((0.2, WALL, DEEP), (0.0, -(WIDE + WALL) / 2, 0.0)),
    _box((0.2, WIDE + 2 * WALL, 0.012), (0.0, 0.0, -DEEP / 2 + 0.006)),
)
HOLDER = Surface(FILLED.vertices, FILLED.faces, FILLED.colors, WALLS)
BOOK = object_model(plain(Box((0.15, 0.03, 0.2))))


def _in(holder: Surface, x: float, y: float, z: float) -> float:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    other = object_model(holder).occupancy
    return shared(BOOK.occupancy, other, T) + shared(other, BOOK.occupancy, np.linalg.inv(T))


@given(st.floats(-0.02, 0.02), st.floats(-0.009, 0.009), st.floats(0.033, 0.1))
def test_what_stands_in_a_hollow_shares_no_space_with_it(x: float, y: float, z: float) -> None:
    assert _in(HOLDER, x, y, z) == 0.0


def test_without_parts_a_hollow_that_looks_filled_is_full() -> None:
    assert _in(Surface(FILLED.vertices, FILLED.faces, FILLED.colors), 0.0, 0.0, 0.05) > 0.005


@given(st.floats(-0.02, 0.02), st.floats(-0.01, 0.01))
def test_what_is_pressed_into_a_bottom_shares_space(x: float, y: float) -> None:
    assert _in(HOLDER, x, y, 0.024) > 0.001


def test_points_lie_on_the_union_alone() -> None:
    halves: Occupancy = occupancy_of_parts(
        [_box((0.1, 0.1, 0.1), (-0.05, 0.0, 0.0)), _box((0.1, 0.1, 0.1), (0.05, 0, 0))]
    )
    assert halves.area == pytest.approx(0.1, rel=0.03)
    assert (np.abs(halves.points[:, 0]) > 0.002).mean() > 0.95
    off = np.abs(halves.points) - (0.1, 0.05, 0.05)
    assert np.allclose(off.max(axis=1), 0.0, atol=1e-9)


@given(st.integers(0, 1000))
def test_inside_is_in_a_part_and_behind_the_nearest_surface(seed: int) -> None:
    space = occupancy_of_parts(WALLS)
    points = np.random.default_rng(seed).uniform(-0.12, 0.12, (200, 3))
    planes = [half_spaces(part) for part in WALLS]
    within = np.any([(points @ A.T <= b).all(axis=1) for A, b in planes], axis=0)
    off = points[:, None] - space.points
    nearest = np.linalg.norm(off, axis=2).argmin(axis=1)
    depth = -np.einsum("nj,nj->n", off[np.arange(200), nearest], space.normals[nearest])
    inside = space.inside(points)
    assert not (inside & ~(within & (depth > INSIDE))).any()
    assert not (within & (depth > 0.0055) & ~inside).any()
