"""The rule of actions whose hand pushes an object: slide, topple and nudge."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from tamp.checking.actions.rule import carry_out, has_steps, named_apart, needs_empty_hand, stands_on
from tamp.task.plan import Fall, Move

if TYPE_CHECKING:
    from tamp.checking.actions.rule import PushCheck
    from tamp.checking.replay import Replay
    from tamp.task.plan import Action


@dataclass(frozen=True)
class Push:
    """The empty hand pushes an object that stands on what the action names.

    Attributes:
        judge: judges the motion that pushes, and brings the object to where that leaves it.
        falls: whether the object falls over when the push ends.
    """

    judge: PushCheck
    falls: bool = False

    def check(self, replay: Replay, action: Action) -> None:
        """Judge the push, and the fall where one follows."""
        if not has_steps(replay, action, "push", *(("drop",) if self.falls else ())):
            return
        named_apart(replay, action, "push", ("approach", "transit"), ("retreat", "transit"))
        if needs_empty_hand(replay, action) and action.arguments and action.arguments[0] in replay.state.poses:
            stands_on(replay, action.arguments[0], action.arguments[1:])
        for before, step in pairwise(action.steps):
            if isinstance(step, Fall) and not (isinstance(before, Move) and before.pushed is not None):
                replay.report("fall", "what is pushed over falls at the end of the push, not later")
        for step in action.steps:
            carry_out(replay, step, push=self.judge)
