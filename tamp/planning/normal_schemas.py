"""Normal form as data: conditions are conjunctions of literals over variables and handles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tamp.planning.objects import Pattern


@dataclass(frozen=True)
class Condition:
    """A conjunction of literals over variables, some of them existentially quantified."""

    positive: tuple[Pattern, ...] = ()
    negative: tuple[Pattern, ...] = ()
    equal: tuple[tuple[str | int, str | int], ...] = ()
    unequal: tuple[tuple[str | int, str | int], ...] = ()

    def __and__(self, other: Condition) -> Condition:
        return Condition(
            tuple(dict.fromkeys(self.positive + other.positive)),
            tuple(dict.fromkeys(self.negative + other.negative)),
            self.equal + other.equal,
            self.unequal + other.unequal,
        )

    def variables(self) -> Iterator[str]:
        """Every variable that occurs, in order, with repetitions."""
        for pattern in self.positive + self.negative:
            yield from (term for term in pattern[1:] if isinstance(term, str))
        for pair in self.unequal:
            yield from (term for term in pair if isinstance(term, str))


@dataclass(frozen=True)
class EffectSchema:
    """`atom` becomes true or false for all bindings of the variables that only occur here that satisfy `condition`."""

    atom: Pattern
    positive: bool
    condition: Condition = Condition()


@dataclass(frozen=True)
class ActionSchema:
    """An action in normal form. `parameters` are the terms of the action's own parameters, after equalities."""

    name: str
    parameters: tuple[str | int, ...]
    condition: Condition
    effects: tuple[EffectSchema, ...]
    cost: tuple[float | Pattern, ...] | None


@dataclass(frozen=True)
class AxiomSchema:
    """`head` holds where `condition` does."""

    head: Pattern
    condition: Condition


@dataclass(frozen=True)
class NormalDomain:
    """All schemas of a problem; the goal is a conjunction of literals without variables."""

    actions: tuple[ActionSchema, ...]
    axioms: tuple[AxiomSchema, ...]
    goal: Condition
    fluents: frozenset[str]
    derived: frozenset[str]
