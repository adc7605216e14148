"""The planner as a contestant: when it takes an object for lost."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("embreex", reason="perception needs the extra 'perception'")

from tamp.contest.samples.planner import LostError, carry_out
from tamp.task import Action, Attachment, Box, Grip, Move, Object, Pose, Task, Trajectory

TASK = Task("thin", (Object("rim", Box((0.1, 0.0038, 0.05)), Pose((0.0, 0.0, 0.025))),))
HELD = Attachment("rim", Pose())


def _robot(width: float) -> Any:
    state = SimpleNamespace(width=width)
    arm = SimpleNamespace(state=lambda: state, follow=lambda *_: None)
    return SimpleNamespace(arm=arm, gripper=SimpleNamespace(go_to=lambda *_: None))


def _action(opening: float) -> Action:
    path = Trajectory(np.array([0.0, 1.0]), np.zeros((2, 7)), np.zeros((2, 7)))
    move = Move("lift", path, opening=opening, held=HELD)
    return Action("pick", ("rim", "table"), (Grip(HELD, opening), move))


@pytest.mark.parametrize(("opening", "width"), [(0.0038, 0.0036), (0.05, 0.049), (0.05, 0.005)])
def test_what_is_thin_is_held_by_fingers_that_nearly_meet(opening: float, width: float) -> None:
    carry_out(_action(opening), cast("Any", _robot(width)), TASK)


@pytest.mark.parametrize(("opening", "width"), [(0.0038, 0.001), (0.05, 0.0)])
def test_fingers_that_meet_have_lost_it(opening: float, width: float) -> None:
    with pytest.raises(LostError, match="rim"):
        carry_out(_action(opening), cast("Any", _robot(width)), TASK)
