"""The planner as a contestant: when it takes an object for lost, and what it knows of what it has brought."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("embreex", reason="perception needs the extra 'perception'")

from tamp.contest.samples.planner import LostError, brought, carry_out
from tamp.perception.estimate import Estimate
from tamp.task import Action, Attachment, Box, Fall, Grip, Move, Object, Pose, Release, Task, Trajectory

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


def test_what_was_brought_is_known_less_surely_and_nothing_else_changes() -> None:
    known = {"rim": Estimate(Pose(), 0.9), "cup": Estimate(Pose((0.3, 0.0, 0.0)), 0.8), "lid": Estimate(None, 0.0)}
    let_go, rests = Pose((0.1, 0.0, 0.1)), Pose((0.1, 0.0, 0.0))
    laid = brought(Action("lay", ("rim", "table"), (Release("rim", let_go, 0.08), Fall("rim", rests))), known)
    assert laid["rim"].pose == rests and 0.0 < laid["rim"].confidence < 0.9
    assert (laid["cup"], laid["lid"]) == (known["cup"], known["lid"])
    assert brought(_action(0.05), known) == known
