from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.streams.hand.finger_closing import closed
from tamp.task import Box, Mesh, Object, Pose
from tests.streams.tables import workspace_of

FACES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
DOWN = Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)).matrix
"""From above, the pads' middle 2 cm over the middle of the object."""


@given(side=st.floats(0.01, 0.07))
def test_fingers_stop_where_the_box_begins(side):
    workspace = workspace_of(Object("box", Box((0.05, side, 0.08)), Pose((0.0, 0.0, 0.04))))
    grasp = closed(workspace, "box", DOWN, side)
    assert grasp is not None
    assert grasp.width == pytest.approx(side, abs=0.001)


def test_fingers_open_as_far_as_was_asked_wherever_they_stop(table):
    grasp = closed(table, "red", DOWN, 0.049, 0.004)
    assert grasp is not None
    assert grasp.width + 2 * grasp.clearance == pytest.approx(0.049 + 2 * 0.004)


def test_fingers_that_something_stops_before_the_contacts_hold_that(table):
    # The box is 5 cm wide: contacts said to be 3 cm apart are inside it.
    grasp = closed(table, "red", DOWN, 0.03)
    assert grasp is not None
    assert grasp.width == pytest.approx(0.05, abs=0.001)


def test_a_rim_that_both_pads_touch_before_the_wall_below_it_is_held(tmp_path: Path):
    # A thin wall under a rim three centimetres wide: the fingers stop at the rim.
    workspace = workspace_of(Object("wall", _rimmed(tmp_path / "wall.obj", 0.03), Pose((0.0, 0.0, 0.05))))
    tool = Pose.from_rpy((0.0, 0.005, 0.04), (np.pi, 0.0, 0.0)).matrix
    grasp = closed(workspace, "wall", tool, 0.004)
    assert grasp is not None
    assert grasp.width == pytest.approx(0.03, abs=0.001)
    assert grasp.T_object_tool.xyz[1] == pytest.approx(0.0, abs=0.001)  # the hand is shifted to the rim's middle


def test_a_rim_above_the_pads_stops_the_fingers_where_they_hold_nothing(tmp_path: Path):
    workspace = workspace_of(Object("wall", _rimmed(tmp_path / "wall.obj", 0.03), Pose((0.0, 0.0, 0.05))))
    tool = Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)).matrix
    assert closed(workspace, "wall", tool, 0.004) is None


@pytest.mark.parametrize(("rim", "held"), [(0.077, True), (0.0798, False)])
def test_what_fills_the_whole_hand_is_not_held_as_the_fingers_could_not_let_go(tmp_path: Path, rim, held):
    workspace = workspace_of(Object("wall", _rimmed(tmp_path / "wall.obj", rim), Pose((0.0, 0.0, 0.05))))
    tool = Pose.from_rpy((0.0, 0.0, 0.04), (np.pi, 0.0, 0.0)).matrix
    assert (closed(workspace, "wall", tool, 0.004) is not None) is held


def _rimmed(path: Path, width: float) -> Mesh:
    """A wall 4 mm thick with a rim on top, as a mesh of two boxes, centred at the origin and 10 cm high."""
    lines, first = [], 1
    for name, half, z in (("wall", 0.002, (-0.05, 0.04)), ("rim", width / 2, (0.04, 0.05))):
        lines.append(f"o {name}")
        lines += [f"v {x} {y} {h}" for x in (-0.05, 0.05) for y in (-half, half) for h in z]
        lines += [f"f {' '.join(str(first + i - 1) for i in face)}" for face in FACES]
        first += 8
    path.write_text("\n".join(lines) + "\n")
    return Mesh(path)
