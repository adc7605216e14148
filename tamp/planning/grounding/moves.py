"""What moves that are left out of the search cost it.

Connectors lead from any value of their fluent to any other, so that the search needs no operator for each pair. It
should still see that two actions at one value need no move between them, and that a way by fewer values is shorter.
One operator for each value that an action or the goal wants stands for all moves there, at the least that one costs.
Where a plan is improved on, among few values, there is one for each pair of them, at what a move between them costs:
which actions are near each other decides in which order they are cheap.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from tamp.planning.grounding.ground_task import TaskEffect, TaskOperator
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.analysis.transit_actions import Connector, Connectors
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
        between: (source, target) -> what a move from one to the other costs; empty where all cost `price`.
    """

    fluent: str = ""
    price: int = 0
    groups: tuple[tuple[Fact, ...], ...] = ()
    targets: frozenset[Fact] = frozenset()
    initial: frozenset[Fact] = frozenset()
    between: Mapping[tuple[Fact, Fact], int] = field(default_factory=dict)

    def wanted(self, operator: GroundOperator) -> tuple[Fact, ...]:
        """What an operator wants of the fluent."""
        return _wanted(operator, self.fluent) if self.fluent else ()

    def changed(self, operator: GroundOperator, number: Callable[[Fact], int]) -> tuple[TaskEffect, ...]:
        """What an operator itself makes of the fluent."""
        return tuple(TaskEffect(number(f), adds) for f, adds in _changed(operator, self.fluent)) if self.fluent else ()

    def operators(self, number: Callable[[Fact], int]) -> Iterator[TaskOperator]:
        """A move to each value that is wanted, or one from each other value to it."""
        for (source, target), price in self.between.items():
            ends = (TaskEffect(number(source), adds=False), TaskEffect(number(target), adds=True))
            yield TaskOperator(None, (number(source),), (), ends, price)
        for group in self.groups if not self.between else ():
            for target in group:
                if target in self.targets:
                    effects = tuple(TaskEffect(number(fact), adds=fact == target) for fact in group)
                    yield TaskOperator(None, (), (), effects, self.price)


class MovePrices:
    """Finds the moves of a task.

    Args:
        connectors: the actions that are left out of the search.
        price: what the search pays for an action of theirs at least.
        between: the same for one of which the two values that it leads between are known, by its variables.
    """

    def __init__(
        self,
        connectors: Connectors,
        price: Callable[[ActionSchema], int],
        between: Callable[[ActionSchema, dict[str, int]], int],
    ) -> None:
        self.fluent = connectors.fluent
        self._position = connectors.connectors[0].position if self.fluent else 0
        self._connectors = connectors.connectors
        self._price = price
        self._between = between

    def over(
        self, operators: Sequence[GroundOperator], state: Iterable[Fact], goal: Iterable[Fact], pairs: bool = False
    ) -> Moves:
        """The moves between operators, from a state and to a goal; `pairs`: each at what it costs itself."""
        price = min((self._price(connector.schema) for connector in self._connectors), default=0)
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
        between = self._prices(made, targets) if pairs else {}
        return Moves(self.fluent, price, made, frozenset(targets), frozenset(initial), between)

    def _prices(self, groups: Iterable[tuple[Fact, ...]], targets: Iterable[Fact]) -> dict[tuple[Fact, Fact], int]:
        """(source, target) -> what the cheapest move costs there."""
        wanted = set(targets)
        pairs = ((a, b) for group in groups for a in group for b in group if b in wanted and a != b)
        return {(a, b): min(self._price_of(c, a, b) for c in self._connectors) for a, b in pairs}

    def _price_of(self, connector: Connector, source: Fact, target: Fact) -> int:
        ends = zip((*connector.before[1:], *connector.after[1:]), (*source[1:], *target[1:]), strict=True)
        return self._between(connector.schema, {t: h for t, h in ends if isinstance(t, str)})


def _wanted(operator: GroundOperator, fluent: str) -> tuple[Fact, ...]:
    return tuple(ground(p, operator.binding) for p in operator.schema.condition.positive if p[0] == fluent)


def _changed(operator: GroundOperator, fluent: str) -> Iterator[tuple[Fact, bool]]:
    for effect in operator.schema.effects:
        if effect.atom[0] == fluent:
            yield ground(effect.atom, operator.binding), effect.positive
