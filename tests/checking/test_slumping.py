"""What leans on something that leaves may slump a little, and may not fall."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.scene import Scene, State
from tamp.checking.slumping import slumps
from tamp.checking.standing import balanced, carriers
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Object, Pose, Task


def plank_on_two_blocks(height, *more):
    """A plank, its ends on two blocks."""
    block = Box((0.04, 0.06, height))
    blocks = [Object(name, block, Pose((x, 0.0, height / 2))) for name, x in (("left", -0.08), ("right", 0.08))]
    plank = Object("plank", Box((0.2, 0.04, 0.02)), Pose((0.0, 0.0, height + 0.01)))
    task = Task("planks", (*blocks, plank, *more))
    return Scene.of(task), State({o.name: o.pose.matrix for o in task.objects}, np.zeros(7))


@given(height=st.floats(0.005, 0.02))
@settings(max_examples=10, deadline=None)
def test_a_plank_on_low_blocks_slumps_where_one_leaves(height):
    scene, state = plank_on_two_blocks(height)
    rest = carriers(scene, state, "plank", DEFAULT).without("right")
    assert balanced(scene, state, "plank", rest, DEFAULT) < 0.0
    assert slumps(scene, state, "plank", "right", DEFAULT)
    assert state.poses["plank"][2, 3] == pytest.approx(height + 0.01)


@given(height=st.floats(0.06, 0.1))
@settings(max_examples=10, deadline=None)
def test_a_plank_on_high_blocks_falls(height):
    scene, state = plank_on_two_blocks(height)
    assert not slumps(scene, state, "plank", "right", DEFAULT)


def test_what_carries_something_may_not_slump():
    rider = Object("rider", Box((0.03, 0.03, 0.03)), Pose((0.0, 0.0, 0.01 + 0.02 + 0.015)))
    scene, state = plank_on_two_blocks(0.01, rider)
    assert not slumps(scene, state, "plank", "right", DEFAULT)


def test_what_nothing_else_carries_falls():
    scene, state = plank_on_two_blocks(0.01)
    del state.poses["left"]
    assert not slumps(scene, state, "plank", "right", DEFAULT)
