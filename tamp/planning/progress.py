"""What a state becomes when an action is taken in it."""

from __future__ import annotations

from collections.abc import Iterable

from tamp.planning.evaluate import Evaluator
from tamp.planning.instances import ground
from tamp.planning.normal_schemas import ActionSchema, Condition
from tamp.planning.objects import Fact
from tamp.planning.state import State


def progress(evaluator: Evaluator, action: ActionSchema, binding: dict[str, int], state: State) -> State:
    """The state after an action with these values; what it adds wins over what it deletes."""
    added: dict[Fact, None] = {}
    deleted: set[Fact] = set()
    for effect in action.effects:
        bindings: Iterable[dict[str, int]] = (binding,)
        if effect.condition != Condition():
            bindings = [b for b, _ in evaluator.satisfy(effect.condition, binding, state)]
        for found in bindings:
            fact = ground(effect.atom, found)
            if effect.positive:
                added[fact] = None
            else:
                deleted.add(fact)
    kept = [fact for fact in state if fact not in deleted or fact in added]
    return State([*kept, *added])
