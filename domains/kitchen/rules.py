"""The checker's rules for cooking and cleaning: whoever checks a plan believes nothing that planned it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from tamp.checking.actions.rule import ActionRule, has_steps, needs_empty_hand, stands_on
from tamp.checking.replay import Replay
from tamp.task import Action


@dataclass(frozen=True)
class Treat:
    """Something that stands in a place of a kind is treated there; the arm takes no part.

    Attributes:
        place: the kind of place, as the task's facts name it.
        needs: what must hold of the object before, or None.
        brings: what holds of it after; `needs` no longer does.
    """

    place: str
    needs: str | None
    brings: str

    def check(self, replay: Replay, action: Action) -> None:
        """The object stands there, the place is of that kind, and the object is ready for it."""
        if not has_steps(replay, action):
            return
        if len(action.arguments) != 2 or action.steps:
            replay.report("precondition", "it is about an object and a place, and moves nothing")
            return
        name, place = action.arguments
        needs_empty_hand(replay, action)
        stands_on(replay, name, (place,))
        facts = replay.state.facts
        if (self.place, place) not in facts:
            replay.report("precondition", f"{place} is no {self.place}", (place,))
        if self.needs is not None:
            if (self.needs, name) not in facts:
                replay.report("precondition", f"{name} is not {self.needs}", (name,))
            facts.discard((self.needs, name))
        facts.add((self.brings, name))


RULES: Mapping[str, ActionRule] = MappingProxyType(
    {"clean": Treat("sink", None, "cleaned"), "cook": Treat("stove", "cleaned", "cooked")}
)
