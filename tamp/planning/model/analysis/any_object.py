"""Parameters of which an action says nothing: any object will do for them, so that one is taken instead of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from tamp.planning.model.normal_form import ActionSchema
from tamp.planning.model.objects import Objects
from tamp.planning.model.schema import Schema


def with_any_object(schema: Schema, objects: Objects, named: Callable[[str], bool]) -> Schema:
    """A problem with an object that it gives in the place of each such parameter.

    `named`: whether somebody asks for certain arguments of an action, which then stays as it is.
    """
    handle = _given(schema, objects)
    if handle is None:
        return schema
    actions = tuple(a if named(a.name) else _with_any(a, handle) for a in schema.actions)
    return schema if actions == schema.actions else schema.with_actions(actions)


def _given(schema: Schema, objects: Objects) -> int | None:
    """The first object that the initial state names."""
    args = (arg for atom in schema.problem.initial_state.facts for arg in atom.args)
    return next((objects.intern(arg.value) for arg in args), None)  # type: ignore[union-attr]


def _with_any(action: ActionSchema, handle: int) -> ActionSchema:
    parameters = {p for p in action.parameters if isinstance(p, str)}
    free = {p for p in parameters if ("object", p) in action.condition.positive} - _mentioned(action)
    if not free:
        return action
    positive = tuple(p for p in action.condition.positive if p[0] != "object" or p[1] not in free)
    return replace(
        action,
        parameters=tuple(handle if p in free else p for p in action.parameters),
        condition=replace(action.condition, positive=positive),
    )


def _mentioned(action: ActionSchema) -> set[str]:
    """The variables of an action that anything but their being objects is said of."""
    rest = [p for p in action.condition.positive if p[0] != "object"]
    found = set(replace(action.condition, positive=tuple(rest)).variables())
    for effect in action.effects:
        found |= {t for t in effect.atom[1:] if isinstance(t, str)} | set(effect.condition.variables())
    patterns = [term for term in action.cost or () if isinstance(term, tuple)]
    return found | {t for p in patterns for t in p[1:] if isinstance(t, str)}
