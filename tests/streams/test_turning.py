import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.squeezed import Squeezed
from tamp.streams.turning import STEP, turning
from tamp.streams.values import Grasp
from tamp.task import Box, Object, Pose
from tests.streams.tables import workspace_of

DOWN = Pose.from_rpy((0, 0, 0), (np.pi, 0, 0))
HALF_TURN = Pose.from_rpy((0, 0, 0), (0, 0, np.pi))


def board(thickness=0.01, mass=0.1, friction=0.5):
    """A board that stands on its edge, thin along y."""
    return Object("board", Box((0.1, thickness, 0.1)), Pose((0.0, 0.1, 0.05)), mass=mass, friction=friction)


def turned(workspace, obj, grasp, *poses):
    return turning(Squeezed(workspace, obj, grasp), *poses)


def turned_in_hand(angle, thickness=0.01, mass=0.1, friction=0.5, offset=0.0, yaw=0.0):
    workspace = workspace_of(board(thickness, mass, friction))
    grasp = Grasp(Pose.from_rpy((offset, 0, 0.03), (angle, 0, yaw)) @ DOWN, thickness)
    return turned(workspace, "board", grasp, workspace.start["board"].pose)


def test_what_lies_flat_between_the_pads_keeps_still():
    assert turned_in_hand(0.0) == 0.0


def test_about_the_closing_axis_the_pads_hold():
    assert turned_in_hand(0.0, offset=0.04, mass=0.5) == 0.0


@pytest.mark.parametrize("angle", [-0.3, -0.2, 0.2, 0.3])
def test_what_is_slanted_between_the_pads_turns_until_it_lies_flat(angle):
    assert turned_in_hand(angle) == pytest.approx(abs(angle), abs=2 * STEP)
    assert turned_in_hand(0.0, yaw=angle) == pytest.approx(abs(angle), abs=2 * STEP)


@pytest.mark.parametrize("angle", [-0.3, 0.3])
def test_what_is_slanted_about_both_axes_turns_about_one_after_the_other(angle):
    assert turned_in_hand(angle, yaw=0.3) == pytest.approx(np.hypot(angle, 0.3), abs=2 * STEP)


def test_friction_holds_what_is_thick_and_a_little_slanted():
    assert turned_in_hand(0.08, thickness=0.06, friction=1.0) == 0.0
    assert turned_in_hand(0.08, thickness=0.06, friction=0.1) > 0.0


@given(angle=st.floats(-0.4, 0.4), thickness=st.floats(0.004, 0.05))
@settings(max_examples=20, deadline=None)
def test_a_hand_turned_by_half_a_turn_holds_as_well(angle, thickness):
    workspace = workspace_of(board(thickness))
    tool = Pose.from_rpy((0, 0, 0.03), (angle, 0, 0)) @ DOWN
    pose = workspace.start["board"].pose
    one, other = (turned(workspace, "board", Grasp(T, thickness), pose) for T in (tool, tool @ HALF_TURN))
    assert one == pytest.approx(other, abs=1.01 * STEP)


def test_the_pose_at_which_it_turns_farthest_counts():
    workspace = workspace_of(board(mass=2.0, friction=0.2))
    grasp = Grasp(Pose.from_rpy((0.04, 0, 0.03), (0.2, 0, 0)) @ DOWN, 0.01)
    standing = workspace.start["board"].pose
    poses = [standing, standing @ Pose.from_rpy((0, 0, 0), (np.pi / 2, 0, 0)), Pose((0.3, 0, 0)) @ standing]
    angles = [turned(workspace, "board", grasp, pose) for pose in poses]
    assert turned(workspace, "board", grasp, *poses) == max(angles)
    assert angles[0] == angles[2]
