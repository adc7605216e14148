"""Fates: what a plan only puts aside is left by it, not wrongly placed."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip("embreex", reason="the extra perception is not installed")

from tamp.perception.belief.belief import Belief
from tamp.perception.estimate import Estimate
from tamp.perception.rendering.surface import plain
from tamp.pipeline.perceived.outcome import outcomes
from tamp.task import Action, Attachment, Box, Grip, Plan, Pose, Release

START, GOAL, ASIDE = Pose((0.0, 0.2, 0.025)), Pose((0.0, -0.2, 0.025)), Pose((0.2, 0.2, 0.025))


def _plan(end: Pose, goals: dict[str, Pose]) -> Plan:
    steps = (Grip(Attachment("box", Pose()), 0.05), Release("box", end, 0.08))
    return Plan("task", "panda", 0, {"box": START}, (), goals, (Action("place", ("box", "table"), steps),))


@pytest.mark.parametrize(
    ("end", "goals", "fate"),
    [
        (ASIDE, {"box": GOAL}, "left by the plan"),
        (GOAL, {"box": GOAL}, "wrongly placed"),
        (ASIDE, {}, "wrongly placed"),
    ],
)
def test_what_is_only_put_aside_is_left_by_the_plan(end: Pose, goals: dict[str, Pose], fate: str) -> None:
    (found,) = outcomes(
        [Belief({"box": Estimate(START, 0.9)})],
        [{"box": START}],
        [_plan(end, goals)],
        SimpleNamespace(goals_met={"box": False}),  # type: ignore[arg-type]  # all that is asked of a score
        {"box": plain(Box((0.05, 0.05, 0.05)))},
        {"box": 1},
        {"box": (ASIDE, GOAL)},
    )
    assert found.fate == fate
