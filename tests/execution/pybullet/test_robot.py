from __future__ import annotations

import math
from pathlib import Path

import pytest

from tamp.execution.executor import execute
from tamp.task import Mesh, Object, Pose, Task
from tests.execution.planning_by_hand import DOWN, HandPlanner

CUP = Mesh(Path(__file__).parents[3] / "scenarios" / "objects" / "cup" / "collision.obj")


def test_what_a_hand_carries_in_a_hurry_stays_in_it_whoever_made_its_description():
    """PyBullet's own Panda asks for anchored friction at its pads; other robots' descriptions cannot."""
    pytest.importorskip("airo_models", reason="the extra 'ur5e' is missing")
    start, end = Pose((-0.2, -0.3, 0.046)), Pose((0.2, 0.3, 0.046))
    task = Task("carry", (Object("cup", CUP, start),), robot="ur5e_2f85")
    hand = HandPlanner(task, {"cup": start})
    hand.pick("cup", Pose((0.0, 0.0, 0.03)) @ DOWN, 0.074, opening=0.085)
    hand.place(end, opening=0.085)
    done = execute(task, hand.plan(), monitor=None, simulator="pybullet")
    assert math.dist(done.final_poses["cup"].xyz[:2], end.xyz[:2]) < 0.0005
