"""Cook and clean beside pick and place: a second domain, small enough to copy from.

A task says which of its regions are sinks and stoves, and what shall be clean or cooked in the end:

    domain: kitchen
    init: [[Sink, basin], [Stove, hob]]
    goal: [[Cleaned, mug], [Cooked, potato]]
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains import tabletop
from tamp.domains.skill import Fact, FactChange, Question, Skill
from tamp.streams.workspace import Workspace
from tamp.task import Action


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """Whatever may be moved may be put into every sink and onto every stove."""
    places = [fact[1] for fact in question.facts if fact[0] in ("sink", "stove")]
    yield from (("Placeable", name, place) for name in workspace.start if question.may_move(name) for place in places)


def facts(action: Action) -> FactChange:
    """What is cleaned is clean; what is cooked is cooked, and clean no more."""
    name = action.arguments[0]
    if action.name == "clean":
        return FactChange(added=(("cleaned", name),))
    return FactChange(added=(("cooked", name),), deleted=(("cleaned", name),))


COOK_AND_CLEAN = Skill(
    name="cook-and-clean",
    actions=("clean", "cook"),
    domain=Path(__file__).parent / "domain.pddl",
    affordances=affordances,
    facts=facts,
    rules="tamp.domains.kitchen.rules:RULES",
    words={"clean": "clean {0} in {rest}", "cook": "cook {0} on {rest}"},
)

DOMAIN = tabletop.DOMAIN.extended(COOK_AND_CLEAN, name="kitchen", strategy="all-at-once")

__all__ = ["COOK_AND_CLEAN", "DOMAIN"]
