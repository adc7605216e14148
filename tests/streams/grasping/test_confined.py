"""Grasps for an arm whose hand hangs straight down wherever it is."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from tamp.streams.grasping.container import upright_pinches
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.workspace import Workspace
from tamp.task import At, Box, Object, Pose
from tamp.task.files.robot.robot_file import read_robot
from tamp.world.robot.model import robot_model
from tests.streams.tables import ToldContext, workspace_of
from tests.task.scara import write

BLOCK = Object(
    "block",
    Box((0.05, 0.05, 0.08)),
    Pose.from_rpy((0.05, 0.15, 0.04), (1e-4, -1e-4, 0.4)),
    At(Pose((0.05, -0.15, 0.04))),
    mass=0.1,
    friction=0.5,
)
"""Higher than what lies low, and as far off upright as what has come to rest is."""


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    return workspace_of(BLOCK, robot=robot_model(read_robot(write(tmp_path_factory.mktemp("scara")))))


def test_all_grasps_come_straight_down_at_start_or_goal_and_the_arm_takes_and_places_with_them(
    workspace: Workspace,
) -> None:
    grasps = list(islice(sample_grasp(ToldContext(workspace), "block"), 10))
    assert len(grasps) == 10
    places = list(workspace.placements_of("block"))
    for grasp in grasps:
        T = [place.pose.matrix @ grasp.T_object_tool.matrix for place in places]
        assert min(np.arccos(-tool[2, 2]) for tool in T) < 1e-5
    served = [
        all(next(inverse_kinematics(ToldContext(workspace), "block", place, grasp), None) for place in places)
        for grasp in grasps
    ]
    assert sum(served) >= 5


def test_hands_that_come_down_into_something_do_not_lean(workspace: Workspace) -> None:
    place = workspace.start["block"]
    pinches = upright_pinches(workspace, "block", place, np.random.default_rng(0))
    down = (place.pose.matrix @ pinches.T_object_tool)[:, 2, 2]
    assert len(pinches) and np.allclose(down, -1.0, atol=1e-9)
