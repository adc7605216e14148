from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tamp.streams.motion.extraction import RISE, UP, extraction, meets, upright
from tamp.task import Box, Object, Pose
from tests.streams.tables import workspace_of

CUBE = Object("cube", Box((0.04, 0.04, 0.04)), Pose((0.0, 0.0, 0.02)))


def roofed(open_at: float) -> tuple[Object, ...]:
    """Two roofs that leave a slit, 5 cm wide, so far aside [m], and a wall on the other side of it."""
    return (
        Object("near", Box((0.2, 0.2, 0.02)), Pose((open_at - 0.125, 0.0, 0.1))),
        Object("far", Box((0.2, 0.2, 0.02)), Pose((open_at + 0.125, 0.0, 0.1))),
    )


def poses_of(*objects: Object) -> dict[str, np.ndarray]:
    return {thing.name: thing.pose.matrix for thing in objects}


@pytest.mark.parametrize("open_at", [0.0, 0.03, -0.03])
def test_it_leads_through_a_slit_beside(open_at):
    roofs = roofed(open_at)
    world = workspace_of(CUBE, *roofs).world
    way = extraction(world, "cube", CUBE.pose.matrix, poses_of(*roofs))
    assert way is not None
    assert way[-1][2] == pytest.approx(RISE * UP)
    corners = np.vstack([np.zeros(3), *way])
    assert not meets(world, "cube", CUBE.pose.matrix, corners, poses_of(*roofs), {})
    assert abs(way[-1][0] - open_at) < 0.006


def test_what_stands_free_goes_straight_up():
    assert extraction(workspace_of(CUBE).world, "cube", CUBE.pose.matrix, {}) == ((0.0, 0.0, RISE * UP),)


@pytest.mark.parametrize("lean", [0.01, 0.2, -0.35])
def test_what_leans_between_two_walls_slides_out_along_its_faces(lean):
    tilt, half = Pose.from_rpy((0.0, 0.0, 0.16), (lean, 0.0, 0.0)), 0.02
    book = Object("book", Box((0.15, 2 * half, 0.2)), tilt)
    walls = [
        Object(name, Box((0.2, 0.02, 0.3)), tilt @ Pose((0.0, side * (half + 0.0101), 0.0)))
        for name, side in (("left", -1), ("right", 1))
    ]
    way = extraction(workspace_of(book, *walls).world, "book", tilt.matrix, poses_of(*walls))
    assert way is not None
    assert np.array(way[-1]) == pytest.approx(tilt.matrix[:3, 2] * np.linalg.norm(way[-1]), abs=1e-4)


@pytest.mark.parametrize("deep", [0.06, 0.19])
def test_what_is_tall_rises_until_it_is_clear_of_what_it_stood_between(deep):
    book = Object("book", Box((0.15, 0.04, 0.25)), Pose((0.0, 0.0, 0.125)))
    walls = [
        Object(name, Box((0.2, 0.02, deep)), Pose((0.0, side * 0.0301, deep / 2)))
        for name, side in (("left", -1), ("right", 1))
    ]
    way = extraction(workspace_of(book, *walls).world, "book", book.pose.matrix, poses_of(*walls))
    assert way is not None
    assert max(RISE * UP, deep) <= way[-1][2] < max(RISE * UP, deep) + 2 * UP


def test_what_is_roofed_over_moves_aside_before_it_rises_on():
    roof = Object("roof", Box((0.12, 0.3, 0.02)), Pose((0.0, 0.0, 0.065)))
    walls = tuple(
        Object(name, Box((0.6, 0.02, 0.2)), Pose((0.0, y, 0.1))) for name, y in (("left", -0.04), ("right", 0.04))
    )
    way = extraction(workspace_of(CUBE, roof, *walls).world, "cube", CUBE.pose.matrix, poses_of(roof, *walls))
    assert way is not None
    assert abs(way[-1][0]) > 0.079


@pytest.mark.parametrize("seed", range(5))
def test_upright_axes_are_those_of_the_rotation_with_the_highest_last(seed):
    R = Rotation.random(random_state=seed).as_matrix()
    axes = upright(R)
    assert np.allclose(axes @ axes.T, np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[2, 2] == pytest.approx(np.abs(R[2]).max())
    assert np.allclose(np.sort(np.abs(R.T @ axes).ravel()), [0.0] * 6 + [1.0] * 3)


def test_there_is_none_where_all_is_shut():
    lid = Object("lid", Box((0.6, 0.6, 0.02)), Pose((0.0, 0.0, 0.08)))
    assert extraction(workspace_of(CUBE, lid).world, "cube", CUBE.pose.matrix, poses_of(lid)) is None
