"""What is written inside something is pushed out of it, and not along it."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.physics.settling import unexplained
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Object, Pose, Task

THICK, SIZE = 0.04, 0.05


def astray(deep: float, out: float, along: float, yaw: float) -> float:
    """How far a block is from where settling takes it that is written `deep` in a wall, and said to stand beside it."""
    turn = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw))
    wall = Object("wall", Box((0.3, THICK, 0.1)), turn @ Pose((0.0, 0.0, 0.05)), mass=5.0)
    beside = (THICK + SIZE) / 2
    block = Object("block", Box((SIZE, SIZE, SIZE)), turn @ Pose((0.0, beside - deep, SIZE / 2)))
    scene = Scene.of(Task("pushed", (wall, block)))
    said = turn @ Pose((along, beside + out, SIZE / 2))
    state = State({"wall": wall.pose.matrix, "block": said.matrix}, np.zeros(7))
    written = {"wall": wall.pose.matrix, "block": block.pose.matrix}
    return unexplained(scene, state, "block", written, DEFAULT)


@given(deep=st.floats(0.002, 0.015), out=st.floats(0.0, 0.003), yaw=st.floats(-3.0, 3.0))
@settings(max_examples=30, deadline=None)
def test_what_is_written_in_a_wall_comes_to_stand_beside_it(deep, out, yaw):
    assert astray(deep, out, 0.0, yaw) == 0.0


@given(deep=st.floats(0.006, 0.015), yaw=st.floats(-3.0, 3.0), to=st.sampled_from([-1.0, 1.0]))
@settings(max_examples=30, deadline=None)
def test_what_is_written_in_a_wall_is_not_pushed_along_it(deep, yaw, to):
    assert astray(deep, 0.0, to * (0.018 + deep), yaw) > 0.0
