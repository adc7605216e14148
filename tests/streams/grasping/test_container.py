from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.streams.affordances.neighbours import enclosed
from tamp.streams.context import Detached
from tamp.streams.grasping import container
from tamp.streams.grasping.container import LEVEL, roomy_pinches
from tamp.streams.grasping.hand_clearance import support_cost
from tamp.streams.hand.candidates import sample_pinches
from tamp.streams.hand.clearance import above_table, clear_of_object, opening_for
from tamp.streams.hand.finger_closing import closed
from tamp.streams.values import CLEARANCE, Placement
from tamp.streams.workspace import TABLE
from tamp.task import Box, Mesh, Object, Pose, Sphere
from tamp.world.scene import Scene
from tests.streams.tables import CUBE, OBJECTS, panda, workspace_of

CRATE = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj", 1.5), Pose((0.10, -0.22, 0.045)))
FLOOR = 0.01
INSIDE = Object("inside", Box((0.04, 0.05, 0.06)), Pose((0.14, -0.2, 0.041 + FLOOR)))
"""Stands in the crate, a hand's breadth from one of its walls."""
CORNER = Object("corner", Sphere(0.028), Pose((0.024, -0.341, 0.035)))
"""Lies in a corner of the crate, so near to both walls that no hand that comes straight down gets between."""


@pytest.fixture(scope="module")
def rack():
    """A plate on edge in the crate between two others that leave little room."""
    mesh = Mesh(OBJECTS / "plate" / "collision.obj")
    plates = [
        Object(name, mesh, Pose.from_rpy((x, -0.22, 0.11), (0.0, np.pi / 2, 0.0)))
        for name, x in (("left", 0.055), ("plate", 0.1), ("right", 0.145))
    ]
    return workspace_of(CRATE, *plates, on={plate.name: ("crate",) for plate in plates})


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(CRATE, INSIDE, CUBE, on={"inside": ("crate",)})


def drawn(workspace, name, seed=0):
    return roomy_pinches(context_of(workspace, seed), name, [workspace.start[name]])


def context_of(workspace, seed=0):
    return Detached(workspace, seed, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(3))
def test_hands_that_reach_into_something_meet_no_wall(workspace, seed):
    pinches = drawn(workspace, "inside", seed)
    assert len(pinches)
    assert not support_cost(workspace, pinches, "inside", workspace.start["inside"]).any()


def test_most_of_them_come_straight_down(workspace):
    approach = (workspace.start["inside"].pose.matrix @ drawn(workspace, "inside").T_object_tool)[:, :3, 2]
    assert np.median(approach[:, 2]) < -0.9


def test_where_it_hangs_over_the_edge_only_hands_are_drawn_that_have_room_there():
    board = Object("board", Box((0.2, 0.16, 0.02)), Pose((-0.1, 0.2, 0.01)))
    workspace = workspace_of(board)
    edge = workspace.task.table.center[1] + workspace.task.table.size[1] / 2
    over = Placement(Pose((-0.1, edge - 0.02, 0.01)), (TABLE,))
    pinches = roomy_pinches(context_of(workspace), "board", [over])
    assert len(pinches) > 20
    assert np.array(above_table(workspace, pinches, over)).all()
    assert len(np.arange(len(pinches))[clear_of_object(workspace, "board", pinches)]) == len(pinches)


def test_what_stands_on_the_table_is_pinched_from_all_around(workspace):
    expected = sample_pinches(workspace, "cube", np.random.default_rng(0))
    assert np.array_equal(drawn(workspace, "cube").T_object_tool, expected.T_object_tool)


def test_for_a_goal_alone_no_room_is_sought_at_the_start(workspace):
    expected = sample_pinches(workspace, "inside", np.random.default_rng(0))
    found = roomy_pinches(context_of(workspace), "inside", [])
    assert np.array_equal(found.T_object_tool, expected.T_object_tool)


def test_walls_are_asked_about_once_wherever_neighbours_stand(monkeypatch):
    beside = Object("beside", Box((0.03, 0.03, 0.03)), Pose((0.09, -0.15, 0.03)))
    workspace = workspace_of(CRATE, INSIDE, beside, on={"inside": ("crate",), "beside": ("crate",)})
    moved = replace(workspace.start["beside"], pose=Pose((0.11, -0.15, 0.03)))
    asked, clear = [], container._clear_of_walls
    monkeypatch.setattr(container, "_clear_of_walls", lambda *args: asked.append(args) or clear(*args))
    first = drawn(workspace, "inside")
    count = len(asked)
    again = drawn(replace(workspace, start={**workspace.start, "beside": moved}), "inside")
    assert 0 < count == len(asked)
    assert len(first)
    assert len(again)
    drawn(workspace, "inside", 1)
    assert len(asked) > count


def test_in_a_corner_hands_lean_over_and_open_less():
    workspace = workspace_of(CRATE, CORNER, on={"corner": ("crate",)})
    pinches = drawn(workspace, "corner")
    assert len(pinches)
    assert not support_cost(workspace, pinches, "corner", workspace.start["corner"]).any()
    wide = pinches.opened(CLEARANCE)
    assert support_cost(workspace, wide, "corner", workspace.start["corner"]).any()
    assert (np.abs(pinches.T_object_tool[:, 2, 1]) > LEVEL).any()


def test_where_no_hand_has_room_there_is_no_pinch():
    fitting = Object("fitting", Box((0.07, 0.07, 0.02)), Pose((0.023, -0.342, 0.0165)))
    workspace = workspace_of(CRATE, fitting, on={"fitting": ("crate",)})
    assert not len(drawn(workspace, "fitting"))


def test_among_neighbours_room_is_judged_as_the_fingers_close(rack):
    place, around = rack.start["plate"], ("crate", "left", "right")
    pinches = drawn(rack, "plate")
    assert len(pinches)
    hand = rack.world.free_hand(Scene({name: rack.start[name].pose.matrix for name in around}), rack.hand.margin)
    for T, width, clearance in zip(pinches.T_object_tool, pinches.widths, pinches.clearances, strict=True):
        grasp = closed(rack, "plate", T, float(width), float(clearance))
        assert grasp is not None
        T_world_tool = place.pose.matrix @ grasp.T_object_tool.matrix
        assert not hand.hit(T_world_tool, opening_for(panda().spec.gripper, grasp))


def test_what_touches_the_table_lies_in_nothing(workspace):
    place = workspace.start["inside"]
    assert enclosed(workspace, "inside", place)
    assert not enclosed(workspace, "inside", replace(place, on=("crate", TABLE)))


def test_a_low_thing_that_is_taken_up_to_be_turned_over_is_gripped_by_hands_that_lean_over_too():
    bar = Object("bar", Box((0.22, 0.03, 0.036)), Pose((0.1, 0.2, 0.018)))
    workspace = workspace_of(bar)
    pinches = drawn(workspace, "bar")
    approach = (bar.pose.matrix @ pinches.T_object_tool.astype(float))[:, :3, 2]
    level = np.abs((bar.pose.matrix @ pinches.T_object_tool)[:, 2, 1]) < 1e-9  # fingers that close exactly level
    assert (approach[level, 2] < -0.99).any()
    assert ((approach[level, 2] > -0.5) & (approach[level, 2] < 0.0)).any()
