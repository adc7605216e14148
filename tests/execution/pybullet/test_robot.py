from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tamp.execution.controller import Operator
from tamp.execution.executor import execute
from tamp.execution.monitor import angle_between
from tamp.execution.simulators import make_simulator
from tamp.task import Attachment, Box, Mesh, Object, Pose, Task, load_robot
from tests.checking.handmade import timed
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


def test_what_is_held_turns_with_the_hand():
    robot = load_robot("panda")
    with make_simulator("pybullet", (), robot=robot) as world:
        T_world_block = world.robot.tool()
    block = Object("block", Box((0.01, 0.046, 0.06)), T_world_block)
    with make_simulator("pybullet", (block,), robot=robot) as world:
        operator = Operator(world)
        world.robot.squeeze(20.0)
        for _ in range(120):
            world.place("block", T_world_block)
            world.step()
        operator.held, held = Attachment("block", Pose()), operator.in_tool("block")
        turned = np.array(robot.home)
        turned[-1] -= 2.8
        operator.follow(timed(np.array([robot.home, turned]), robot, share=0.5))
        assert angle_between(operator.in_tool("block"), held) < 0.01
