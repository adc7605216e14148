"""Nudging: what lies in something is pushed on a little in there."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains.skill import SAMPLED, Fact, Question, Skill
from tamp.domains.tabletop.skills.push import effect, steps
from tamp.streams.affordances.nudges import nudgeable
from tamp.streams.workspace import Workspace

FOLDER = Path(__file__).parent


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """Which goals are so near within the same container that a push brings an object there."""
    for name, goal in workspace.goals.items():
        start = workspace.start[name]
        if goal != start and nudgeable(workspace, name, start, goal):
            yield ("Nudgeable", name, start, goal)


NUDGE = Skill(
    name="nudge",
    actions=("nudge",),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={"plan-nudging": "tamp.streams.pushing.nudge:plan_nudging"},
    info={"plan-nudging": SAMPLED},
    affordances=affordances,
    steps=steps,
    effect=effect,
    words={"nudge": "nudge {0} in {rest}"},
)
