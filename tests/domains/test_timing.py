from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from tamp.domains.timing import Timing
from tamp.streams.affordances.friction_cones import TABLE_FRICTION
from tamp.streams.affordances.nudges import nudged
from tamp.streams.hand.hand_boxes import hand_boxes
from tamp.streams.pushing.nudge import plan_nudging
from tamp.streams.pushing.slide import plan_sliding
from tamp.task import Attachment, Box, Object, Pose
from tamp.world.robot.payload import GRAVITY
from tests.streams.pushing.test_slide import BOX
from tests.streams.tables import ToldContext, panda, workspace_of


def test_the_hand_that_pushes_slows_down_less_than_what_is_slippery_would():
    slide = next(plan_sliding(ToldContext(workspace_of(BOX)), "box", workspace_of(BOX).start["box"]))[-1]
    pushed, took = Attachment("box", slide.T_tool_object), []
    for friction in (0.5, 0.1, 0.02):
        workspace = workspace_of(replace(BOX, friction=friction))
        motion = Timing(workspace, {}).push(pushed, slide.push, slide.opening, ("table",)).trajectory
        times = np.linspace(0.0, motion.duration, 200)
        at = np.array([np.interp(times, motion.times, column) for column in motion.positions.T]).T
        tools = np.array([panda().forward(q)[:3, 3] for q in at])
        speeds = np.linalg.norm(np.diff(tools, axis=0), axis=1) / np.diff(times)
        slowing = -np.diff(speeds[::4]) / (4 * times[1])
        assert slowing.max() < 9.81 * friction
        took.append(motion.duration)
    assert took[0] < took[1] < took[2] < 4 * took[1]


BLOCK = Object("block", Box((0.05, 0.05, 0.06)), Pose((0.1, -0.22, 0.03)))


@pytest.mark.parametrize("friction", [0.3, 0.46, 0.6])
def test_what_is_pushed_high_up_is_sped_up_and_slowed_down_so_little_that_its_inertia_does_not_tip_it(friction):
    workspace = workspace_of(replace(BLOCK, friction=friction))
    start = workspace.start["block"]
    end = nudged(start, np.array([0.0, 0.03, 0.0]))
    shares = []
    for *_, nudge in islice(plan_nudging(ToldContext(workspace), "block", start, end), 4):
        pushed = Attachment("block", nudge.T_tool_object)
        motion = Timing(workspace, {}).push(pushed, nudge.push, nudge.opening, ("table",)).trajectory
        at = np.array([panda().forward(q)[:3, 3] for q in motion.positions])
        speeds = np.concatenate([[0.0], np.linalg.norm(np.diff(at, axis=0), axis=1) / np.diff(motion.times), [0.0]])
        between = np.concatenate([motion.times[:1], (motion.times[1:] + motion.times[:-1]) / 2, motion.times[-1:]])
        rate = np.abs(np.diff(speeds) / np.diff(between)).max()
        height = at[0, 2] - hand_boxes(panda()).tip(nudge.opening)
        taken = friction * TABLE_FRICTION * height + abs(height - 0.03) * rate / GRAVITY
        shares.append(taken / 0.025)
    assert shares and max(shares) < 0.9
