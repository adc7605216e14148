"""Tilted release: an object is let go before it is all the way down, and falls flat, or straight into something."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains.skill import SAMPLED, Fact, Question, Skill
from tamp.domains.tabletop.handling import put_down, put_down_effect
from tamp.planning import StreamInfo
from tamp.streams.affordances.falls import may_fall
from tamp.streams.workspace import TABLE, Workspace

FOLDER = Path(__file__).parent
EFFORT = 5.0  # in calls of another stream, so that an object is rather put down than laid down


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """Which goals an object may be let fall to."""
    for name, goal in workspace.goals.items():
        if goal != workspace.start[name]:
            if goal.on == (TABLE,):
                yield ("LaidOnTable", name, goal)
            if name not in question.regrasped and may_fall(workspace, name, goal):
                yield ("Layable", name, goal)


TILTED_RELEASE = Skill(
    name="tilted-release",
    actions=("lay", "lay-on"),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "plan-bringing": "tamp.streams.releasing.tilted_release:plan_bringing",
        "plan-laying": "tamp.streams.releasing.tilted_release:plan_laying",
    },
    info={"plan-bringing": SAMPLED, "plan-laying": StreamInfo(complete=False, cost=EFFORT)},
    affordances=affordances,
    steps=put_down,
    effect=put_down_effect,
    words={"lay": "lay {0} on {rest}", "lay-on": "lay {0} on {rest}"},
)
