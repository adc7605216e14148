"""What leans on something that leaves may slump a little, and may not fall."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp import load_task
from tamp.checking.actions.left_standing import check_uncovered
from tamp.checking.physics.contacts import Contacts, Patch
from tamp.checking.physics.support import balanced, carriers, slumps, unrest, without_part
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.execution.settling.settle import settle
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.task import Box, Object, Pose, Table, Task
from tamp.world.geometry.object_geometry import load_geometry

DATA = Path(__file__).parents[4] / "shared" / "ocrtoc"


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


def let_go_above(raised, lower):
    """The plank, level and a little above its blocks, of which one is lower than the other."""
    scene, state = plank_on_two_blocks(0.05)
    state.poses["plank"] = Pose((0.0, 0.0, 0.06 + raised)).matrix
    state.poses["right"] = Pose((0.08, 0.0, 0.025 - lower)).matrix
    return scene, state


@given(raised=st.floats(0.0, 0.0028), lower=st.floats(0.0, 0.0024))
@settings(max_examples=15, deadline=None)
def test_what_is_let_go_sinks_to_what_stops_it_before_it_is_asked_what_carries_it(raised, lower):
    assert not list(unrest(*let_go_above(raised, lower), "plank", DEFAULT))


@given(raised=st.floats(0.0, 0.0028), lower=st.floats(0.0038, 0.02))
@settings(max_examples=15, deadline=None)
def test_it_sinks_no_further_than_to_the_first_that_stops_it(raised, lower):
    assert list(unrest(*let_go_above(raised, lower), "plank", DEFAULT))


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


RACK = {
    "plate_holder": Pose((0.09949, 0.19966, 0.00111), (0.68492, 0.17595, 0.17591, 0.68483)),
    "round_plate_1_2": Pose((0.06537, 0.20482, 0.09596), (-0.14774, 0.74631, 0.17614, 0.62464)),
    "round_plate_2": Pose((0.10389, 0.18914, 0.08434), (-0.08104, 0.70042, 0.24384, 0.66587)),
    "round_plate_2_2": Pose((0.13789, 0.20641, 0.08417), (-0.14502, 0.67423, 0.19095, 0.69851)),
}
"""Plates as they stood in their rack after one had been taken out of it."""


@pytest.mark.skipif(not DATA.is_dir(), reason="OCRTOC's data is not at ../shared/ocrtoc")
@pytest.mark.parametrize(
    ("leaving", "falls"), [("round_plate_1_2", False), ("round_plate_2", False), ("plate_holder", True)]
)
def test_plates_in_a_rack_may_give_a_little_and_the_rack_may_not_leave(tmp_path, leaving, falls):
    paths = import_ocrtoc(DATA / "2021", tmp_path).paths
    task = load_task(next(path for path in paths if path.stem == "4-3-1"))
    objects = tuple(replace(obj, pose=RACK[obj.name], goal=None) for obj in task.objects if obj.name in RACK)
    task = replace(task, objects=objects)
    scene, poses = Scene.of(task), {name: pose.matrix for name, pose in RACK.items()}
    said: list[str] = []
    check_uncovered(scene, State(poses, np.zeros(7)), leaving, DEFAULT, lambda _, told, **__: said.append(told))
    rest = settle(task, {other: pose for other, pose in RACK.items() if other != leaving}).poses
    moved = max(scene.displacement(other, poses[other], pose.matrix) for other, pose in rest.items())
    assert bool(said) == falls == (moved > DEFAULT.slump)


SHAPES = (Box((0.05, 0.08, 0.06)), Box((0.12, 0.04, 0.02)), load_task("scenarios/stand_up_can.yaml").objects[0].shape)


@given(
    shape=st.sampled_from(SHAPES), beyond=st.floats(0.002, 0.02), above=st.floats(0.0, 0.0028), yaw=st.floats(0.0, 3.1)
)
@settings(max_examples=30, deadline=None)
def test_what_has_its_centre_of_mass_beyond_the_edge_of_the_table_falls_however_little_it_sinks(
    shape, beyond, above, yaw
):
    half = load_geometry(shape).hull.vertices[:, 2].max()
    table = Table()
    y = table.center[1] - table.size[1] / 2 - beyond
    pose = Pose.from_rpy((0.0, y, half + above), (0.0, 0.0, yaw))
    scene = Scene.of(Task("edge", (Object("thing", shape, pose),), table=table))
    assert list(unrest(scene, State({"thing": pose.matrix}, np.zeros(7)), "thing", DEFAULT))
