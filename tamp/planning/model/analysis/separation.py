"""A fluent told apart by what it speaks of, such as where the robot is and where things are.

Where one predicate serves both, `(at ?robot ?q)` and `(at ?thing ?p)`, nothing can be said of the robot's alone: that
moves lead from any place to any other, or that no axiom asks where it is. Where the objects that a literal may speak of
follow from the static conditions beside it, the two parts are given names of their own inside the planner.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from tamp.planning.model.normal_form import AxiomSchema, Condition
from tamp.planning.model.objects import Fact, Part, Pattern
from tamp.planning.model.schema import Schema

NEW = -1
"""An object that a stream gives: any, for all that is known."""

Range = frozenset[int] | None
"""The objects that a term may stand for; None where nothing is known of it."""


class Ranges:
    """Which objects may occur at each position of a static predicate: given ones, and what streams pass on."""

    def __init__(self, schema: Schema, given: Iterable[Fact]) -> None:
        self._changing = schema.fluents | schema.derived | {"=", "object"}
        self._at: dict[tuple[str, int], frozenset[int]] = {}
        for fact in given:
            self._extend(fact, lambda term: frozenset([int(term)]))
        size = -1
        while size < (size := sum(map(len, self._at.values()))):
            for external in schema.externals.values():
                condition = Condition(external.domain)
                for pattern in external.certified:
                    self._extend(pattern, lambda t, c=condition, e=external: self._given(t, c, e.inputs))  # type: ignore[misc]

    def _extend(self, pattern: Pattern | Fact, of: Callable[[str | int], frozenset[int]]) -> None:
        for i, term in enumerate(pattern[1:], start=1):
            key = (str(pattern[0]), i)
            self._at[key] = self._at.get(key, frozenset()) | of(term)

    def _given(self, term: str | int, condition: Condition, inputs: tuple[str, ...]) -> frozenset[int]:
        found = self.of(term, condition) if isinstance(term, int) or term in inputs else None
        return frozenset([NEW]) if found is None else found

    def of(self, term: str | int, condition: Condition) -> Range:
        """The objects that a term may stand for where a condition holds."""
        if isinstance(term, int):
            return frozenset([term])
        found: Range = None
        for pattern in condition.positive:
            for i, other in enumerate(pattern[1:], start=1):
                if other == term and pattern[0] not in self._changing:
                    here = self._at.get((str(pattern[0]), i), frozenset())
                    found = here if found is None else _common(found, here)
        return found


def _common(one: frozenset[int], other: frozenset[int]) -> frozenset[int]:
    """What may be in both, where a new object may be any."""
    return one & other | (other if NEW in one else frozenset()) | (one if NEW in other else frozenset())


def separations(schema: Schema, given: Iterable[Fact]) -> Iterator[Part]:
    """How fluents can be told apart by what some action asks of an object that it speaks of."""
    ranges = Ranges(schema, given)
    asked = {str(p[0]) for e in schema.externals.values() for p in (*e.domain, *e.awaited, *e.certified, *e.guarded)}
    seen: set[Part] = set()
    for action in schema.actions:
        for effect in action.effects:
            for position, term in enumerate(effect.atom[1:], start=1):
                things = ranges.of(term, action.condition) or frozenset()
                found = Part(str(effect.atom[0]), position, things)
                if NEW in things or not things or found in seen or found.fluent in asked:
                    continue
                seen.add(found)
                parts = {_is_part(found, *use, ranges) for use in _uses(schema) if use[0][0] == found.fluent}
                if parts == {True, False}:
                    yield found


def _uses(schema: Schema) -> Iterator[tuple[Pattern, Condition]]:
    """Every literal, with what holds beside it."""
    for action in schema.actions:
        yield from ((p, action.condition) for p in action.condition.positive + action.condition.negative)
        for effect in action.effects:
            beside = action.condition & effect.condition
            yield from ((p, beside) for p in (effect.atom, *effect.condition.positive, *effect.condition.negative))
    for condition in (schema.goal, *(axiom.condition for axiom in schema.axioms)):
        yield from ((p, condition) for p in condition.positive + condition.negative)


def _is_part(part: Part, pattern: Pattern, beside: Condition, ranges: Ranges) -> bool | None:
    """Whether a literal is of the part, or of the rest for sure; None where it may be of both."""
    if pattern[0] != part.fluent:
        return False
    range_ = ranges.of(pattern[part.position], beside)
    if range_ is None or NEW in range_ or (range_ & part.things and range_ - part.things):
        return None
    return bool(range_ & part.things)


def separated(schema: Schema, part: Part, given: Iterable[Fact]) -> Schema:
    """The schema with the part of the fluent under its own name."""
    ranges = Ranges(schema, given)

    def named(pattern: Pattern, beside: Condition) -> Pattern:
        return (part.name, *pattern[1:]) if _is_part(part, pattern, beside, ranges) else pattern

    def condition(old: Condition, beside: Condition) -> Condition:
        positive = tuple(named(p, beside) for p in old.positive)
        return replace(old, positive=positive, negative=tuple(named(p, beside) for p in old.negative))

    actions = []
    for action in schema.actions:
        effects = []
        for effect in action.effects:
            beside = action.condition & effect.condition
            effects.append(
                replace(effect, atom=named(effect.atom, beside), condition=condition(effect.condition, beside))
            )
        actions.append(replace(action, condition=condition(action.condition, action.condition), effects=tuple(effects)))
    axioms = tuple(AxiomSchema(a.head, condition(a.condition, a.condition)) for a in schema.axioms)
    return schema.with_part(part, tuple(actions), axioms, condition(schema.goal, schema.goal))
