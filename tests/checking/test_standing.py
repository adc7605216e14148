"""What an action may say that an object stands on."""

import numpy as np
import pytest

from tamp.checking.scene import Scene, State
from tamp.checking.standing import carriers, without_part
from tamp.checking.support import Contacts, Patch
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Object, Pose, Task


@pytest.fixture(scope="module")
def touching():
    """A board that leans with its upper edge on an upright wall, its foot on a block; a second block is near."""
    tilt, thick, high = 0.3, 0.02, 0.2
    reach = (high * np.sin(tilt) + thick * np.cos(tilt)) / 2
    height = (high * np.cos(tilt) + thick * np.sin(tilt)) / 2
    wall = Object("wall", Box((0.04, 0.1, 0.22)), Pose((reach + 0.02, 0.0, 0.16)))
    block = Object("block", Box((0.2, 0.1, 0.05)), Pose((0.0, 0.0, 0.025)))
    other = Object("other", Box((0.04, 0.1, 0.05)), Pose((0.0, 0.2, 0.025)))
    board = Object("board", Box((thick, 0.08, high)), Pose.from_rpy((0.0, 0.0, 0.05 + height), (0.0, tilt, 0.0)))
    task = Task("leaning", (wall, block, other, board))
    state = State({o.name: o.pose.matrix for o in task.objects}, np.zeros(7))
    return carriers(Scene.of(task), state, "board", DEFAULT)


def test_what_stands_on_one_body_may_lean_on_another(touching):
    assert {"block", "wall"} <= set(touching.patches)
    assert without_part(touching, ["block"]) == []
    assert without_part(touching, ["block", "wall"]) == []


def test_what_it_does_not_touch_has_no_part_in_that(touching):
    assert without_part(touching, ["block", "other"]) == ["other"]
    assert without_part(touching, ["other"]) == ["other"]


def test_nothing_leans_that_stands_on_nothing():
    beside = Patch(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]))
    assert without_part(Contacts({"wall": beside}), ["wall"]) == ["wall"]
