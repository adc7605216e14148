"""Connectors: actions such as "move" that lead from any value of one fluent to any other.

Where an action only changes one argument of one fluent, between any two values, and the outputs of its streams are used
nowhere else, the search need not see it: it is put into the plan afterwards, wherever two actions want different
values. Grounding it would take a number of operators that grows with the square of the number of values.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from tamp.planning.model.external import External
from tamp.planning.model.normal_form import ActionSchema, Condition, EffectSchema
from tamp.planning.model.objects import Pattern
from tamp.planning.model.schema import Schema


@dataclass(frozen=True)
class Connector:
    """An action that changes one argument of a fluent from `source` to `target`.

    Attributes:
        before, after: the fluent's patterns; they differ only at `position`.
        streams: the streams that certify its static conditions, in an order in which inputs come first, each with
            the pattern that it must certify.
        fluents: the part of its condition that the state decides and that must hold.
        negative: what must not hold, in the state from which it leads away.
        static: the rest.
    """

    schema: ActionSchema
    before: Pattern
    after: Pattern
    position: int
    streams: tuple[tuple[External, Pattern], ...]
    fluents: Condition
    negative: tuple[Pattern, ...]
    static: tuple[Pattern, ...]

    @property
    def fluent(self) -> str:
        """The predicate whose argument it changes."""
        return str(self.before[0])


class Connectors:
    """The connectors of a domain; none where it has none or the planner was told to keep every action in the search.

    Attributes:
        fluent: the predicate whose argument they change; empty without connectors.
        private: derived predicates that nothing else asks for; the search need not see them either.
        streams: the streams that moves are made of.
    """

    def __init__(self, schema: Schema, enabled: bool = True) -> None:
        self.schema = schema
        found: tuple[Connector, ...] = ()
        if enabled:
            candidates = tuple(c for a in schema.actions if (c := _recognise(schema, a)) is not None)
            for fluent in dict.fromkeys(c.fluent for c in candidates):
                group = tuple(c for c in candidates if c.fluent == fluent)
                if not found and _only_between_actions(schema, group):
                    found = group
        self.connectors = found
        self.fluent = found[0].fluent if found else ""
        self._names = {c.schema.name for c in found}
        self.private = _private(schema, found)
        self.streams = frozenset(external.name for c in found for external, _ in c.streams)
        self.spent = {str(e.atom[0]) for c in found for e in c.schema.effects if e.atom[0] != self.fluent}

    def is_connector(self, name: str) -> bool:
        """Whether the action is left out of the search."""
        return name in self._names

    def without(self, condition: Condition) -> Condition:
        """A condition without the fluent that connectors look after."""
        if not self.fluent:
            return condition
        hidden = {self.fluent}
        return replace(condition, positive=tuple(p for p in condition.positive if p[0] not in hidden))

    def effects(self, schema: ActionSchema) -> Iterable[EffectSchema]:
        """An action's effects without those on the fluent that connectors look after."""
        return (e for e in schema.effects if not self.fluent or e.atom[0] != self.fluent)


def _recognise(schema: Schema, action: ActionSchema) -> Connector | None:
    """Read an action as a connector, or None where it does more."""
    plain = [e for e in action.effects if e.condition == Condition()]
    added = [e.atom for e in plain if e.positive]
    if len(plain) != len(action.effects) or len(added) != 1:
        return None
    after = added[0]
    deleted = [e.atom for e in plain if not e.positive]
    before = next((p for p in deleted if p[0] == after[0]), None)
    if before is None or before not in action.condition.positive:
        return None
    differ = [i for i in range(1, len(after)) if after[i] != before[i]]
    kept = {t for t in before[1:] if t in after[1:]}  # what moves, as in (CanMove ?robot)
    if not all(kept.issuperset(p[1:]) for p in deleted if p is not before):
        return None
    if len(differ) != 1 or not all(isinstance(p[differ[0]], str) for p in (before, after)):
        return None
    if any(p[0] in schema.derived for p in action.condition.positive):
        return None
    if any(p[0] in schema.fluents for p in action.condition.negative):
        return None  # what other actions bring about may bar every move: the search must see that
    streams = _streams(schema, action, before, after, differ[0])
    if streams is None:
        return None
    fluents = Condition(positive=tuple(p for p in action.condition.positive if p[0] in schema.fluents))
    static = tuple(p for p in action.condition.positive if p[0] not in schema.fluents)
    return Connector(action, before, after, differ[0], streams, fluents, action.condition.negative, static)


def _streams(
    schema: Schema, action: ActionSchema, before: Pattern, after: Pattern, position: int
) -> tuple[tuple[External, Pattern], ...] | None:
    """The streams that can certify the static conditions for any two values; None where something else decides them."""
    fluent_terms = {t for p in action.condition.positive if p[0] in schema.fluents for t in p[1:]}
    known = {str(t) for t in fluent_terms if isinstance(t, str)} | {str(after[position])}
    pending = [p for p in action.condition.positive if p[0] not in schema.fluents]
    moved = {t for t in before[1:] if t in after[1:]}
    found: list[tuple[External, Pattern]] = []
    while pending:
        progress = False
        for pattern in list(pending):
            if known.issuperset(pattern[1:]) and len(moved.union(pattern[1:])) <= len(moved) + 1:
                pending.remove(pattern)  # a type of one value: certified with it, checked when the move is made
                progress = True
                continue
            external = _certifier(schema, pattern, known)
            if external is not None:
                pending.remove(pattern)
                found.append((external, pattern))
                known |= {t for t in pattern[1:] if isinstance(t, str)}
                progress = True
        if not progress:
            return None
    return tuple(found)


def _certifier(schema: Schema, pattern: Pattern, known: set[str]) -> External | None:
    for external in schema.externals.values():
        for certified in external.certified:
            if certified[0] != pattern[0]:
                continue
            terms = dict(zip(certified[1:], pattern[1:], strict=True))
            simple = all(len(d) <= 3 for d in external.domain)
            new = known.isdisjoint(str(terms.get(v)) for v in external.outputs)  # what is known cannot be chosen
            if simple and new and all(terms.get(v) in known for v in external.inputs):
                return external
    return None


def _only_between_actions(schema: Schema, group: tuple[Connector, ...]) -> bool:
    """Whether nothing but positive preconditions and plain effects of actions speaks of the fluent."""
    fluent = group[0].fluent
    if len({c.position for c in group}) != 1:
        return False
    names = {c.schema.name for c in group}
    others = [action for action in schema.actions if action.name not in names]
    outputs = {str(p[0]) for c in group for external, _ in c.streams for p in external.certified}
    spent = {str(e.atom[0]) for c in group for e in c.schema.effects} - {fluent}
    effects = [e.condition for a in schema.actions for e in a.effects]
    if any(p[0] != fluent and p[0] in _lost(schema) for c in group for p in c.fluents.positive):
        return False  # a move must come before what ends all moves, not just before the action that wants its value
    everywhere = [c.negative for c in group] + [schema.goal.negative]
    everywhere += [c.positive + c.negative for c in (*effects, *(axiom.condition for axiom in schema.axioms))]
    if any(p[0] == fluent for patterns in everywhere for p in patterns):
        return False
    elsewhere = [*effects, schema.goal, *(action.condition for action in others)]
    elsewhere += [axiom.condition for axiom in schema.axioms if axiom.head[0] not in _private(schema, group)]
    if any(p[0] in outputs | spent for c in elsewhere for p in c.positive + c.negative):
        return False
    return all(_tolerates(action, fluent, spent) for action in others)


def _lost(schema: Schema) -> set[str]:
    """Predicates that actions make false and none makes true again."""
    effects = [effect for action in schema.actions for effect in action.effects]
    added = {str(effect.atom[0]) for effect in effects if effect.positive}
    return {str(effect.atom[0]) for effect in effects if not effect.positive} - added


def _private(schema: Schema, group: tuple[Connector, ...]) -> frozenset[str]:
    """Derived predicates that only connectors want to be false, such as "something is in this path's way"."""
    names = {c.schema.name for c in group}
    elsewhere = [schema.goal, *(axiom.condition for axiom in schema.axioms)]
    elsewhere += [a.condition for a in schema.actions if a.name not in names]
    elsewhere += [e.condition for a in schema.actions for e in a.effects]
    shared = {p[0] for c in elsewhere for p in c.positive + c.negative}
    return frozenset(str(p[0]) for c in group for p in c.negative if p[0] in schema.derived and p[0] not in shared)


def _tolerates(action: ActionSchema, fluent: str, spent: set[str]) -> bool:
    """Whether another action works with moves put in before it."""
    condition = action.condition
    if any(p[0] == fluent for p in condition.negative) or any(p[0] in spent for p in condition.positive):
        return False
    touched = [e for e in action.effects if e.atom[0] == fluent]
    wanted = [p for p in condition.positive if p[0] == fluent]
    if (touched and not wanted) or any(not e.positive and e.atom[0] in spent for e in action.effects):
        return False
    covered = {t for p in condition.positive if p[0] != fluent for t in p[1:]}
    return {t for p in wanted for t in p[1:] if isinstance(t, str)} <= covered
