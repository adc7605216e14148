"""Pick, place and unstack at a table, and what else helps there: the domain that tasks are planned in by default."""

from dataclasses import replace

from tamp.domains.domain import Domain
from tamp.domains.skill import Question
from tamp.domains.tabletop.facts import TABLETOP, goal
from tamp.domains.tabletop.skills import SKILLS
from tamp.streams.workspace import Workspace


def regrasping(workspace: Workspace, question: Question) -> Question:
    """The same question where whatever has a goal pose shall be regrasped on its way."""
    moving = {name for name, goal in workspace.goals.items() if goal != workspace.start[name]}
    return replace(question, regrasped=moving)


DOMAIN = Domain("tabletop", (TABLETOP, *SKILLS), goal, strategy="serialized", variants=(regrasping,))

__all__ = ["DOMAIN", "regrasping"]
