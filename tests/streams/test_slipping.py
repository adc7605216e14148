import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.slipping import slipping
from tamp.streams.squeezed import Squeezed
from tamp.streams.values import Grasp
from tamp.task import Box, Mesh, Object, Pose
from tests.streams.tables import workspace_of

DOWN = Pose.from_rpy((0, 0, 0), (np.pi, 0, 0))


def wedge(slant, folder, height=0.06):
    """The path of a wedge whose two faces across y lean by `slant` [rad]; narrow at the top where that is positive."""
    ends = [(0.02 - z * np.tan(slant), z) for z in (-height / 2, height / 2)]
    corners = [(x, side * half, z) for x in (-0.03, 0.03) for half, z in ends for side in (-1, 1)]
    path = folder / "wedge.obj"
    trimesh.convex.convex_hull(np.array(corners)).export(path)
    return path


def slipped(slant, folder, friction=0.5, mass=0.1):
    item = Object("wedge", Mesh(wedge(slant, folder)), Pose((0.0, 0.1, 0.03)), mass=mass, friction=friction)
    workspace = workspace_of(item)
    grasp = Grasp(DOWN, 0.04)
    return slipping(Squeezed(workspace, "wedge", grasp), workspace.start["wedge"].pose)


@given(slant=st.floats(-0.2, 0.2))
@settings(max_examples=20, deadline=None)
def test_what_is_nearly_parallel_keeps_still(slant, tmp_path_factory):
    assert slipped(slant, tmp_path_factory.mktemp("wedges")) == 0.0


@pytest.mark.parametrize("slant", [-0.6, 0.6])
def test_what_is_steeper_than_the_cone_of_friction_shoots_out(slant, tmp_path):
    assert slipped(slant, tmp_path) > 0.01


def test_more_friction_holds_what_is_steeper(tmp_path):
    assert slipped(0.5, tmp_path, friction=0.5) > 0.01
    assert slipped(0.5, tmp_path, friction=1.0) == 0.0


def test_weight_draws_down_what_friction_hardly_holds(tmp_path):
    assert slipped(0.3, tmp_path, mass=0.01) == 0.0
    assert slipped(0.0, tmp_path, mass=20.0) > 0.01


def test_a_block_at_the_tip_of_the_fingers_is_held(tmp_path):
    block = Object("block", Box((0.05, 0.04, 0.05)), Pose((0.0, 0.1, 0.025)))
    workspace = workspace_of(block)
    grasp = Grasp(Pose((0.0, 0.0, 0.028)) @ DOWN, 0.04)
    assert slipping(Squeezed(workspace, "block", grasp), workspace.start["block"].pose) == 0.0
