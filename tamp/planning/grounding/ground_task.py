"""The ground planning task of one moment: what operators and axioms amount to when its optimistic facts hold."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.objects import Fact


@dataclass(frozen=True, slots=True)
class TaskEffect:
    """Atom `atom` becomes true or false where all of `positive` and none of `negative` hold."""

    atom: int
    adds: bool
    positive: tuple[int, ...] = ()
    negative: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class TaskOperator:
    """An operator over atom numbers. `cost` is what the search minimises: the action's cost and its reluctance.

    `source` is None where it is no action: it stands for the assumption that a test holds, which has its price.
    """

    source: GroundOperator | None
    positive: tuple[int, ...]
    negative: tuple[int, ...]
    effects: tuple[TaskEffect, ...]
    cost: int


@dataclass(frozen=True, slots=True)
class TaskAxiom:
    """Atom `head` holds where all of `positive` and none of `negative` hold."""

    head: int
    positive: tuple[int, ...]
    negative: tuple[int, ...]


@dataclass(frozen=True)
class GroundTask:
    """A STRIPS task with axioms. Atoms are numbered; `goal` is None where it is out of reach even without deletes.

    Attributes:
        groups: sets of atoms of which at most one is true at a time.
    """

    atoms: tuple[Fact, ...]
    initial: frozenset[int]
    goal_positive: tuple[int, ...]
    goal_negative: tuple[int, ...]
    operators: tuple[TaskOperator, ...]
    axioms: tuple[TaskAxiom, ...]
    groups: tuple[tuple[int, ...], ...] = ()
    solvable: bool = True


def axiom_layers(axioms: Iterable[TaskAxiom]) -> dict[int, int]:
    """Head -> stratum: above what its bodies negate, not below what they use.

    Raises:
        ValueError: where a derived atom depends on its own negation.
    """
    axioms = list(axioms)
    layer = {axiom.head: 0 for axiom in axioms}
    for _ in range(len(layer) + 1):
        changed = False
        for axiom in axioms:
            least = max(
                [layer[a] for a in axiom.positive if a in layer] + [layer[a] + 1 for a in axiom.negative if a in layer],
                default=0,
            )
            if least > layer[axiom.head]:
                layer[axiom.head] = least
                changed = True
        if not changed:
            return layer
    raise ValueError("a derived predicate depends on its own negation")
