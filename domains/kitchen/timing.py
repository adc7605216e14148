"""From a kitchen's solution to timed actions: the arm's as in the tabletop domain, its own without a motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tamp.domains import tabletop
from tamp.streams.workspace import Workspace
from tamp.task import Action

OWN = ("clean", "cook")


def assemble(workspace: Workspace, solution: Sequence[Any]) -> tuple[Action, ...]:
    """Timed actions in the order of the solution; see `tamp.domains.tabletop.assemble`.

    Args:
        workspace: where they happen, objects at their start.
        solution: the planner's ground actions.

    Raises:
        NotFree: where a timed motion touches something.
    """
    timed = iter(tabletop.assemble(workspace, [ground for ground in solution if ground.name not in OWN]))
    return tuple(Action(g.name, tuple(g.args), ()) if g.name in OWN else next(timed) for g in solution)
