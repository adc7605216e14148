from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.domains.timing import Timing
from tamp.streams.pushing.slide import plan_sliding
from tamp.task import Attachment
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
