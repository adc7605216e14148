"""Invariants: sets of atoms of which at most one is true at a time, such as "an object is at one pose or in the hand".

A candidate names predicates, each with the argument that all its atoms share (or none). It is kept where every action
that adds an atom of it also requires and deletes one with the same shared argument (a simple form of the synthesis in
Helmert, "Concise finite-domain representations for PDDL planning tasks", 2009).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from tamp.planning.model.normal_form import ActionSchema, Condition
from tamp.planning.model.objects import Fact, Pattern
from tamp.planning.model.schema import Schema

MAX_PARTS = 4


@dataclass(frozen=True)
class Invariant:
    """(predicate, position of the shared argument or 0) for each of its predicates, sorted."""

    parts: tuple[tuple[str, int], ...]

    def key(self, pattern: Pattern) -> tuple[str | int, ...] | None:
        """What an atom's group shares; None where the atom is no part of it."""
        for name, position in self.parts:
            if pattern[0] == name:
                return (pattern[position],) if position else ()
        return None


def find_invariants(schema: Schema, hidden: str = "") -> tuple[Invariant, ...]:
    """The invariants of a domain's actions, apart from the predicate that connectors look after."""
    arity = {str(e.atom[0]): len(e.atom) - 1 for a in schema.actions for e in a.effects}
    arity.pop(hidden, None)
    queue = [Invariant(((name, position),)) for name in sorted(arity) for position in range(arity[name] + 1)]
    seen = set(queue)
    found: list[Invariant] = []
    while queue:
        candidate = queue.pop(0)
        repairs = _repairs(candidate, schema.actions, arity)
        if repairs is None:
            found.append(candidate)
            continue
        for extended in repairs:
            if extended not in seen:
                seen.add(extended)
                queue.append(extended)
    return tuple(found)


def _repairs(candidate: Invariant, actions: tuple[ActionSchema, ...], arity: dict[str, int]) -> list[Invariant] | None:
    """None where the candidate is an invariant; otherwise the larger ones that might be."""
    for action in actions:
        added = [(e, key) for e in action.effects if e.positive and (key := candidate.key(e.atom)) is not None]
        if any(effect.condition != Condition() for effect, _ in added):
            return []
        if len(added) > 1:  # their shared arguments might be one object, or they are the same group
            keys = [key for _, key in added]
            if not all(_differ(a, b, action) for i, a in enumerate(keys) for b in keys[:i]):
                return []
        for effect, key in added:
            if not any(key == candidate.key(p) for p in _consumed(action) if p != effect.atom):
                return list(_extensions(candidate, key, action, arity))
    return None


def _consumed(action: ActionSchema) -> list[Pattern]:
    """Atoms that an action requires and deletes."""
    plain = [e.atom for e in action.effects if not e.positive and e.condition == Condition()]
    return [p for p in plain if p in action.condition.positive]


def _differ(a: tuple[str | int, ...], b: tuple[str | int, ...], action: ActionSchema) -> bool:
    if a == b:
        return False
    pairs = {frozenset(pair) for pair in action.condition.unequal}
    return frozenset((*a, *b)) in pairs or all(isinstance(t, int) for t in (*a, *b))


def _extensions(
    candidate: Invariant, key: tuple[str | int, ...], action: ActionSchema, arity: dict[str, int]
) -> Iterator[Invariant]:
    if len(candidate.parts) >= MAX_PARTS:
        return
    names = {name for name, _ in candidate.parts}
    for pattern in _consumed(action):
        if pattern[0] in names or pattern[0] not in arity:
            continue
        positions: Iterable[int] = [i for i in range(1, len(pattern)) if (pattern[i],) == key] if key else [0]
        for position in positions:
            yield Invariant(tuple(sorted((*candidate.parts, (str(pattern[0]), position)))))


def groups(invariants: tuple[Invariant, ...], atoms: Iterable[Fact], state: Iterable[Fact]) -> list[list[Fact]]:
    """Partition atoms into groups of which at most one is true, larger groups first; single atoms are left out."""
    true = set(state)
    every: list[list[Fact]] = []
    atoms = list(atoms)
    for invariant in invariants:
        table: dict[tuple[str | int, ...], list[Fact]] = {}
        initial: dict[tuple[str | int, ...], int] = {}
        for fact in true:
            if (key := invariant.key(fact)) is not None:
                initial[key] = initial.get(key, 0) + 1
        for fact in atoms:
            if (key := invariant.key(fact)) is not None and initial.get(key, 0) <= 1:
                table.setdefault(key, []).append(fact)
        every += [group for group in table.values() if len(group) > 1]
    taken: set[Fact] = set()
    chosen: list[list[Fact]] = []
    for group in sorted(every, key=len, reverse=True):
        rest = [fact for fact in group if fact not in taken]
        if len(rest) > 1:
            chosen.append(rest)
            taken.update(rest)
    return chosen
