"""Sliding: what no hand can take as it lies is pushed over the table's edge, to be gripped there, or to its goal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains.skill import SAMPLED, Fact, Question, Skill
from tamp.domains.tabletop.skills.push import effect, steps
from tamp.streams.affordances.slide_path import slidable, ways_to
from tamp.streams.grasping.hand_room import hemmed_in
from tamp.streams.workspace import Workspace

FOLDER = Path(__file__).parent


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """Which objects need it where they are, and which it may bring straight to their goals."""
    for name, placement in workspace.start.items():
        if not question.may_move(name):
            continue
        if alone := slidable(workspace, name, placement):
            yield ("Slidable", name, placement)
        goal = workspace.goals.get(name, placement)
        if ways_to(workspace, name, placement, goal) and (alone or hemmed_in(workspace, name)):
            yield ("SlidableTo", name, placement, goal)


SLIDE = Skill(
    name="slide",
    actions=("slide",),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "plan-sliding": "tamp.streams.pushing.slide:plan_sliding",
        "plan-detour": "tamp.streams.pushing.slide:plan_detour",
        "plan-sliding-to": "tamp.streams.pushing.slide:plan_sliding_to",
    },
    info={"plan-sliding": SAMPLED, "plan-detour": SAMPLED, "plan-sliding-to": SAMPLED},
    affordances=affordances,
    steps=steps,
    effect=effect,
    words={"slide": "slide {0} over {rest}"},
)
