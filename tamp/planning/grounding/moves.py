"""What moves that are left out of the search cost it.

Connectors lead from any value of their fluent to any other, so that the search needs no operator for each pair. It
should still see that two actions at one value need no move between them, and that a way by fewer values is shorter.
One operator for each value that an action or the goal wants stands for all moves there, at the least that one costs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from tamp.planning.grounding.ground_task import TaskEffect, TaskOperator
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.normal_form import ActionSchema
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import ground

MANY = 40
"""Values that may be wanted for the search to see what moves cost; plans with moves in them are twice as long."""


@dataclass(frozen=True)
class Moves:
    """The moves of one task; none where they cost nothing, or lead to too many values.

    Attributes:
        fluent: what they change; empty without moves.
        price: what the search pays for one.
        groups: values of which one holds at a time.
        targets: those that are wanted.
        initial: those that hold at the start.
    """

    fluent: str = ""
    price: int = 0
    groups: tuple[tuple[Fact, ...], ...] = ()
    targets: frozenset[Fact] = frozenset()
    initial: frozenset[Fact] = frozenset()

    def wanted(self, operator: GroundOperator) -> tuple[Fact, ...]:
        """What an operator wants of the fluent."""
        return _wanted(operator, self.fluent) if self.fluent else ()

    def changed(self, operator: GroundOperator, number: Callable[[Fact], int]) -> tuple[TaskEffect, ...]:
        """What an operator itself makes of the fluent."""
        return tuple(TaskEffect(number(f), adds) for f, adds in _changed(operator, self.fluent)) if self.fluent else ()

    def operators(self, number: Callable[[Fact], int]) -> Iterator[TaskOperator]:
        """A move to each value that is wanted."""
        for group in self.groups:
            for target in group:
                if target in self.targets:
                    effects = tuple(TaskEffect(number(fact), adds=fact == target) for fact in group)
                    yield TaskOperator(None, (), (), effects, self.price)


class MovePrices:
    """Finds the moves of a task.

    Args:
        connectors: the actions that are left out of the search.
        price: what the search pays for an action of theirs at least.
    """

    def __init__(self, connectors: Connectors, price: Callable[[ActionSchema], int]) -> None:
        self.fluent = connectors.fluent
        self._position = connectors.connectors[0].position if self.fluent else 0
        self._schemas = [connector.schema for connector in connectors.connectors]
        self._price = price

    def over(self, operators: Sequence[GroundOperator], state: Iterable[Fact], goal: Iterable[Fact]) -> Moves:
        """The moves between operators, from a state and to a goal."""
        price = min(map(self._price, self._schemas), default=0)
        if not price:
            return Moves()
        initial = [fact for fact in state if fact[0] == self.fluent]
        targets = dict.fromkeys(fact for fact in goal if fact[0] == self.fluent)
        for operator in operators:
            targets.update(dict.fromkeys(_wanted(operator, self.fluent)))
            if len(targets) > MANY:
                return Moves()
        others = (fact for operator in operators for fact, _ in _changed(operator, self.fluent))
        groups: dict[tuple[object, ...], list[Fact]] = {}
        for fact in dict.fromkeys((*initial, *targets, *others)):
            groups.setdefault((*fact[: self._position], *fact[self._position + 1 :]), []).append(fact)
        if any(len([fact for fact in group if fact in initial]) > 1 for group in groups.values()):
            return Moves()
        made = tuple(map(tuple, groups.values()))
        return Moves(self.fluent, price, made, frozenset(targets), frozenset(initial))


def _wanted(operator: GroundOperator, fluent: str) -> tuple[Fact, ...]:
    return tuple(ground(p, operator.binding) for p in operator.schema.condition.positive if p[0] == fluent)


def _changed(operator: GroundOperator, fluent: str) -> Iterator[tuple[Fact, bool]]:
    for effect in operator.schema.effects:
        if effect.atom[0] == fluent:
            yield ground(effect.atom, operator.binding), effect.positive
