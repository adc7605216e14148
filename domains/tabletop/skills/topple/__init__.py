"""Toppling: what no hand can grasp as it stands is pushed over one of its edges, to be gripped as it lies then."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains.skill import SAMPLED, Fact, Question, Skill
from tamp.domains.tabletop.skills.push import effect, steps
from tamp.streams.affordances.topple_path import topplable
from tamp.streams.workspace import Workspace

FOLDER = Path(__file__).parent


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """Which objects need it where they are, or would need it where they shall be."""
    for name, placement in workspace.start.items():
        if question.may_move(name) and topplable(workspace, name, placement):
            yield ("Topplable", name, placement)


TOPPLE = Skill(
    name="topple",
    actions=("topple",),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={"plan-toppling": "tamp.streams.pushing.topple:plan_toppling"},
    info={"plan-toppling": SAMPLED},
    affordances=affordances,
    steps=steps,
    effect=effect,
    words={"topple": "topple {0} on {rest}"},
)
