from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.streams.affordances.stable_poses import stands
from tamp.streams.affordances.topple_path import BEYOND, to_be_pushed, topplable, topples
from tamp.streams.values import Placement
from tamp.task import Box, Mesh, Object, Pose
from tests.streams.tables import OBJECTS, corners, workspace_of

PAIL = Object("pail", Mesh(OBJECTS / "pail" / "collision.obj"), Pose.from_rpy((-0.02, -0.05, 0.07), (np.pi, 0.0, 0.4)))
SQUAT = Object("squat", Box((0.14, 0.14, 0.06)), Pose((0.1, 0.3, 0.03)))
POST = Object("post", Box((0.07, 0.12, 0.16)), Pose((0.1, -0.3, 0.08)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(PAIL, SQUAT, POST)


def test_only_what_no_hand_can_grasp_is_toppled(workspace):
    assert topplable(workspace, "pail", workspace.start["pail"])
    assert not topplable(workspace, "post", workspace.start["post"])
    upright = Placement(Pose((0.0, 0.0, 0.07)), ("table",))
    assert not topplable(workspace, "pail", upright)  # by its rim


def test_what_slides_before_it_tips_is_not_toppled(workspace):
    assert not topples(workspace, "squat", workspace.start["squat"])
    slippery = workspace_of(replace(PAIL, friction=0.3))
    assert not topples(slippery, "pail", slippery.start["pail"])


def test_what_stands_on_other_things_is_not_toppled(workspace):
    assert not topplable(workspace, "pail", replace(workspace.start["pail"], on=("squat",)))


def test_what_is_slid_or_toppled_is_pushed(workspace):
    pushed = {name for name in ("pail", "squat", "post") if to_be_pushed(workspace, name, workspace.start[name])}
    assert pushed == {"pail", "squat"}


def test_every_topple_turns_about_an_edge_past_the_balance_and_ends_on_a_face(workspace):
    geometry = workspace.world.geometries["pail"]
    found = topples(workspace, "pail", workspace.start["pail"])
    assert len(found) == 4
    for topple in found:
        before, left, after = (
            corners(workspace, "pail", pose) for pose in (topple.pushed[0], topple.pushed[-1], topple.fall[-1])
        )
        assert topple.pushed[-1] == topple.fall[0] and topple.end.pose == topple.fall[-1]
        still = np.linalg.norm(left - before, axis=1) < 1e-6
        assert still.sum() >= 2 and np.ptp(before[still] @ topple.ahead) < 1e-6  # what is on the edge
        center = topple.pushed[-1].matrix @ np.append(geometry.center_of_mass, 1.0)
        assert (center[:3] - left[still][0]) @ topple.ahead > BEYOND
        np.testing.assert_allclose(after[still], before[still], atol=1e-6)
        assert stands(geometry, topple.end.pose.matrix[:3, :3])
        assert after[:, 2].min() == pytest.approx(0.0, abs=1e-6)


def test_nothing_is_toppled_off_the_table():
    table = workspace_of(SQUAT).task.table
    edge = table.center[0] + table.size[0] / 2
    standing = replace(PAIL, pose=Pose.from_rpy((edge - 0.06, 0.0, 0.07), (np.pi, 0.0, 0.0)))
    workspace = workspace_of(standing)
    found = topples(workspace, "pail", workspace.start["pail"])
    assert found and all(topple.ahead[0] < 0.5 for topple in found)
