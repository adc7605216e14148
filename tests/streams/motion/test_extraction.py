from __future__ import annotations

import numpy as np
import pytest

from tamp.streams.motion.extraction import RISE, UP, extraction, meets
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


def test_there_is_none_where_all_is_shut():
    lid = Object("lid", Box((0.6, 0.6, 0.02)), Pose((0.0, 0.0, 0.08)))
    assert extraction(workspace_of(CUBE, lid).world, "cube", CUBE.pose.matrix, poses_of(lid)) is None
