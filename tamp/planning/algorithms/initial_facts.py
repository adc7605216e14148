"""What a run begins with: the facts that a problem gives, and those that an earlier plan has left."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tamp.language import Atom
from tamp.planning.model.awaited import OWN_MARK
from tamp.planning.model.objects import Fact, Objects
from tamp.planning.model.schema import Schema, valued
from tamp.planning.options import Reuse


@dataclass(frozen=True)
class Known:
    """What one session tells the next, with values: facts without fluents, a state, what streams brought into it."""

    facts: tuple[Fact, ...]
    state: tuple[Fact, ...]
    brought: tuple[Fact, ...] = ()


def initial_facts(schema: Schema, objects: Objects, reuse: Reuse | None) -> Iterator[Fact]:
    """What is given to hold, with the supertypes of each object; and every object that the problem names."""
    domain = schema.domain
    for name, types in domain.constant_types.items():
        handle = objects.intern(domain.constants[name].value)
        yield ("object", handle)
        for kind in types:
            yield from ((t, handle) for t in (kind, *domain.supertypes(kind)) if t != "object")
    for atom in schema.problem.initial_state.facts:
        fact = schema.inner(given_fact(atom, objects))
        yield fact
        if atom.predicate in domain.types:
            yield from ((above, fact[1]) for above in domain.supertypes(atom.predicate) if above != "object")
    for term in schema.problem.initial_state.values:
        yield (valued(term.function), *(objects.intern(arg.value) for arg in term.args))  # type: ignore[union-attr]
    for pattern in schema.goal.positive + schema.goal.negative:
        yield from (("object", term) for term in pattern[1:] if isinstance(term, int))
    if reuse is not None:
        yield from _reused(schema, objects, reuse)


def given_fact(atom: Atom, objects: Objects) -> Fact:
    """An atom of the initial state, by handles."""
    return (atom.predicate, *(objects.intern(arg.value) for arg in atom.args))  # type: ignore[union-attr]


def _reused(schema: Schema, objects: Objects, reuse: Reuse) -> Iterator[Fact]:
    """Facts of an earlier plan about the values that its remaining actions use.

    What streams with fluents certified held in one state only, and is left out.
    """
    momentary = {str(p[0]) for e in schema.externals.values() if e.fluents for p in e.certified}
    for action in reuse.actions:
        for value in action.args:
            objects.intern(value)
    known = set(objects.real())
    for raw in reuse.facts:
        name = str(raw[0]).lower()
        if name in schema.fluents | schema.guarded or name in momentary or name.startswith(OWN_MARK):
            continue
        fact = (name, *map(objects.intern, raw[1:]))
        if known.issuperset(fact[1:]):
            yield fact
