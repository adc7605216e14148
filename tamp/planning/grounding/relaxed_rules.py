"""What may bring about what, as rules without negative conditions: a relaxation of actions, axioms and streams."""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass

from tamp.planning.model.external import External
from tamp.planning.model.objects import Pattern
from tamp.planning.model.schema import Schema


@dataclass(frozen=True)
class Rule:
    """Where all of `body` holds, so does `head`; `name` says so, an action, a derived predicate or a stream.

    Attributes:
        unequal: terms that must differ.
        external: the stream, where it is one.
    """

    name: str
    head: Pattern
    body: tuple[Pattern, ...]
    unequal: tuple[tuple[str | int, str | int], ...] = ()
    external: External | None = None


def relaxed_rules(schema: Schema) -> Iterator[Rule]:
    """Actions, axioms and streams without their negative conditions."""
    for action in schema.actions:
        for effect in action.effects:
            if effect.positive:
                body, unequal = action.condition.positive, action.condition.unequal
                more = effect.condition
                yield Rule(action.name, effect.atom, _checked(body + more.positive), unequal + more.unequal)
    for axiom in schema.axioms:
        yield Rule(str(axiom.head[0]), axiom.head, _checked(axiom.condition.positive), axiom.condition.unequal)
    for external in schema.externals.values():
        for certified in external.certified:
            body = _checked(external.domain + external.awaited)
            yield Rule(external.name, certified, body, external=external)


def call_rules(schema: Schema, head: Pattern, streams: Container[str]) -> Iterator[Rule]:
    """That `head` holds once one of these streams may be called."""
    for external in schema.externals.values():
        if external.name in streams:
            yield Rule(external.name, head, _checked(external.domain + external.awaited), external=external)


def _checked(body: tuple[Pattern, ...]) -> tuple[Pattern, ...]:
    """Conditions without equalities, each once."""
    return tuple(dict.fromkeys(p for p in body if p[0] != "="))
