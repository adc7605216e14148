"""Atoms as numbers, with simple derived atoms replaced by their definitions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from tamp.planning.grounding.ground_task import TaskEffect
from tamp.planning.grounding.operators import GroundEffect
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact

NOGOOD = "@nogood"
"""Predicate of derived atoms that say that a set of facts holds in which a stream is known to fail."""


BROKEN = "@broken"
"""Predicate of derived atoms that say that a conjunction does not hold."""


Literals = tuple[tuple[int, ...], tuple[int, ...]]


Body = tuple[tuple[Fact, ...], tuple[Fact, ...]]


class Numbering:
    """Numbers atoms as they are used, and puts simple derived atoms in their definitions' place."""

    def __init__(
        self, state: dict[Fact, None], reached: set[Fact], bodies: dict[Fact, list[Body]], knowledge: Knowledge
    ) -> None:
        self._state = state
        self._reached = reached
        self._bodies = bodies
        self._knowledge = knowledge
        self._derived = knowledge.schema.derived | {NOGOOD, BROKEN}
        self._recursive = knowledge.schema.recursive
        self._numbers: dict[Fact, int] = {}
        self._axiomatic: dict[Fact, None] = {}
        self._kinds: dict[Fact, list[Fact]] = {}

    def true(self, fact: Fact) -> bool:
        """Whether a derived atom holds whatever happens."""
        if fact[0] not in self._derived:
            return False
        free = (not p and self._reached.isdisjoint(n) for p, n in self._bodies.get(fact, ()))
        return self._knowledge.usable(fact) or any(free)

    def nogood(self, facts: tuple[Fact, ...], alone: Collection[str] = ()) -> Fact:
        """A derived atom that holds where all of some facts do, and no other facts of the predicates `alone`."""
        head = (NOGOOD, *facts, *alone)
        if head not in self._bodies:
            others = tuple(sorted(f for f in self._reached if f[0] in alone and f not in facts)) if alone else ()
            self._bodies[head] = [(facts, others)] if all(f in self._reached for f in facts) else []
            self._reached.add(head)
        return head

    def of_kinds(self, kinds: Iterable[Fact]) -> Iterator[Fact]:
        """The atoms within reach of some facts that have lineages in place of objects."""
        for kind in kinds:
            if kind not in self._kinds:
                alike = (f for f in self._reached if f[0] == kind[0])
                lineage = self._knowledge.lineage
                self._kinds[kind] = sorted(f for f in alike if (f[0], *map(lineage, f[1:])) == kind)
            yield from self._kinds[kind]

    def known(self, fact: Fact) -> bool:
        """Whether an atom is within reach."""
        return fact in self._reached

    def of(self, fact: Fact) -> int:
        """The number of an atom."""
        return self._numbers.setdefault(fact, len(self._numbers))

    def atoms(self) -> tuple[Fact, ...]:
        """All atoms that have a number, in order."""
        return tuple(self._numbers)

    def axiomatic(self) -> list[Fact]:
        """Derived atoms that need axioms, those that their bodies mention included."""
        done: dict[Fact, None] = {}
        while len(done) < len(self._axiomatic):
            for head in list(self._axiomatic):
                if head not in done:
                    done[head] = None
                    for body in self._bodies[head]:
                        self.literals(*body)
        return list(done)

    def literals(
        self, positive: Iterable[Fact], negative: Iterable[Fact]
    ) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
        """Atom numbers of a conjunction; None where it can never hold."""
        plus: dict[int, None] = {}
        minus: dict[int, None] = {}
        if not all(self._positive(f, plus, minus) for f in positive):
            return None
        if not all(self._negative(f, plus, minus) for f in negative):
            return None
        return None if plus.keys() & minus.keys() else (tuple(plus), tuple(minus))

    def _positive(self, fact: Fact, plus: dict[int, None], minus: dict[int, None]) -> bool:
        if fact not in self._reached:
            return False
        if fact[0] in self._derived:
            if self.true(fact):
                return True
            bodies = self._bodies.get(fact, [])
            if len(bodies) == 1 and all(f[0] not in self._derived for part in bodies[0] for f in part):
                return all(self._positive(f, plus, minus) for f in bodies[0][0]) and all(
                    self._negative(f, plus, minus) for f in bodies[0][1]
                )
            self._axiomatic[fact] = None
        plus[self.of(fact)] = None
        return True

    def _negative(self, fact: Fact, plus: dict[int, None], minus: dict[int, None]) -> bool:
        if fact not in self._reached:
            return True
        if fact[0] in self._derived:
            if self.true(fact):
                return False
            if fact[0] not in self._recursive:
                return all(self._broken(body, plus, minus) for body in self._bodies.get(fact, ()))
            self._axiomatic[fact] = None
        minus[self.of(fact)] = None
        return True

    def _broken(self, body: Body, plus: dict[int, None], minus: dict[int, None]) -> bool:
        """Demand that a conjunction does not hold: one literal is negated, of several any is, by a new derived atom.

        Heuristics see through such positive axioms, but not through the negation of a derived atom.
        """
        positive, negative = body
        if len(positive) + len(negative) == 1:
            return all(self._negative(f, plus, minus) for f in positive) and all(
                self._positive(f, plus, minus) for f in negative
            )
        head = (BROKEN, body)
        if head not in self._bodies:
            self._bodies[head] = [((), (f,)) for f in positive] + [((f,), ()) for f in negative]
            if any(f in self._reached for f in negative) or positive:
                self._reached.add(head)
        return self._positive(head, plus, minus)

    def effect(self, effect: GroundEffect) -> TaskEffect | None:
        """An effect over numbers; None where it can never happen."""
        if effect.atom not in self._reached:
            return None
        literals = self.literals(effect.positive, effect.negative)
        return None if literals is None else TaskEffect(self.of(effect.atom), effect.adds, *literals)
