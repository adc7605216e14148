"""The planner as a contestant: when it takes an object for lost, and what it knows of what it has brought."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("embreex", reason="perception needs the extra 'perception'")

from tamp.contest.api.client import Goal, GoalObject
from tamp.contest.samples.planner import LostError, brought, carry_out, standing
from tamp.formats.obj import shape_obj
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


def test_what_looks_a_little_inside_another_is_known_where_both_come_to_rest(tmp_path: Path) -> None:
    """Of things in each other nothing is planned: the sample looked again until its rounds were over."""
    (tmp_path / "cube.obj").write_bytes(shape_obj(Box((0.05, 0.05, 0.06))))
    things = {n: GoalObject(n, tmp_path / "cube.obj", None, 0.1, 0.5, np.eye(4), None, None) for n in ("a", "b")}
    goal, robot = Goal("two", things, (0.0, 0.0, 0.8, 1.2, 0.05)), SimpleNamespace(name="panda")
    seen = {"a": Estimate(Pose((0.1, 0.0, 0.03)), 0.9), "b": Estimate(Pose((0.145, 0.0, 0.033)), 0.9)}
    found = standing(goal, cast("Any", robot), seen)
    a, b = (found[name].pose for name in "ab")
    assert a is not None and b is not None and b.xyz[0] - a.xyz[0] > 0.0495 and abs(b.xyz[2] - 0.03) < 1e-3
