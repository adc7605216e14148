"""A pile is built and taken down so that it never tips."""

from __future__ import annotations

import pytest

import tamp
from tamp.checking import check
from tamp.task import At, Box, Object, Pose, Task

BLOCK = Object("block", Box((0.05, 0.05, 0.06)), Pose((0.05, 0.0, 0.03)))
PLANK = Object("plank", Box((0.3, 0.05, 0.02)), Pose((0.05, 0.0, 0.07)), mass=0.05)
END, MIDDLE = Pose((-0.07, 0.0, 0.11)), Pose((0.05, 0.0, 0.11))
ASIDE = Pose((0.0, 0.25, 0.03)), Pose((0.1, 0.25, 0.03))


def weights(at: tuple[Pose, Pose], to: tuple[Pose, Pose]) -> Task:
    """A light weight for the end of a plank and a heavy one for its middle, which holds it down."""
    made = [
        Object(name, Box((0.04, 0.04, 0.06)), start, At(goal), mass=mass)
        for name, mass, start, goal in zip(("end", "middle"), (0.2, 2.0), at, to, strict=True)
    ]
    return Task("pile", (BLOCK, PLANK, *made))


@pytest.mark.parametrize("built", [True, False])
def test_the_weight_that_holds_a_plank_down_comes_first_and_leaves_last(built):
    ends = (ASIDE, (END, MIDDLE)) if built else ((END, MIDDLE), ASIDE)
    task = weights(*ends)
    plan = tamp.plan(task, seed=0)
    assert check(task, plan).accepted
    assert _moved(plan) == (["middle", "end"] if built else ["end", "middle"])


def _moved(plan) -> list[str]:
    return [action.arguments[0] for action in plan.actions if action.name in ("unstack", "pick")]
