import numpy as np
import pytest

from tamp.streams.rims import held_up
from tamp.streams.tilting import tilts
from tamp.streams.values import Placement
from tamp.task import At, Box, Mesh, Object, Pose
from tests.streams.tables import OBJECTS, workspace_of

LYING = Pose.from_rpy((0.10, -0.15, 0.0341), (0.0, np.pi / 2, 0.0))
BLOCK = Object("block", Box((0.06, 0.10, 0.07)), Pose((0.05, 0.20, 0.035)), At(LYING))
CRATE = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj", scale=0.6), Pose((0.10, -0.15, 0.018)))
SHELF = Object("shelf", Box((0.3, 0.3, 0.02)), Pose((0.10, -0.15, -0.0065)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BLOCK, CRATE, SHELF)


def held(workspace, name):
    """Tilts from which the block would be held up [degrees], and those from which it falls."""
    place, below = Placement(LYING, (name,)), {name: workspace.start[name]}
    found = {True: set(), False: set()}
    for tilt in tilts(workspace, "block", place):
        found[held_up(workspace, "block", tilt.fall, below)].add(round(np.degrees(tilt.angle)))
    return found[True], found[False]


def test_nothing_is_held_up_on_a_flat_support(workspace):
    assert held(workspace, "shelf")[0] == set()


def test_a_block_that_is_tilted_far_over_the_rim_of_a_crate_is_held_up_there(workspace):
    up, falling = held(workspace, "crate")
    assert up
    assert min(falling) == 10
    assert min(up) > 20


def test_what_touches_nothing_is_not_held_up(workspace):
    fall = (Pose.from_rpy((0.1, 0.2, 0.5), (0.3, 0.0, 0.0)), Pose((0.1, 0.2, 0.45)))
    assert not held_up(workspace, "block", fall, {"crate": workspace.start["crate"]})
