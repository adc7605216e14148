"""Incremental joins: which instances of which rules have all their conditions among the facts that have arrived so far.

Semi-naive evaluation as in Datalog: a new fact is matched against every position of every rule body, and only the rest
of the body is looked up, each condition through an index on the positions that are bound by then.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tamp.planning.join_order import Step, join_order
from tamp.planning.objects import Fact, Pattern


@dataclass(frozen=True)
class JoinRule:
    """`on_match` is called once with the handles of `variables` for each way in which all of `body` is satisfied.

    Attributes:
        variables: every variable of the body, in the order in which `on_match` gets their values.
        body: patterns that must match facts; each variable occurs in at least one.
        unequal: pairs of terms that must differ.
    """

    variables: tuple[str, ...]
    body: tuple[Pattern, ...]
    unequal: tuple[tuple[str | int, str | int], ...]
    on_match: Callable[[tuple[int, ...]], None]


class Join:
    """Facts and the rules they feed. Facts may be added from within `on_match`."""

    def __init__(self, rules: Sequence[JoinRule]) -> None:
        self.facts: dict[Fact, None] = {}
        self._queue: deque[Fact] = deque()
        self._busy = False
        self._indices: dict[str, dict[tuple[int, ...], dict[tuple[int, ...], list[Fact]]]] = {}
        self._watchers: dict[str, list[tuple[JoinRule, tuple[Step, ...]]]] = {}
        self._empty = [rule for rule in rules if not rule.body]
        for rule in rules:
            for first in range(len(rule.body)):
                self._indices.setdefault(str(rule.body[first][0]), {})
                steps = join_order(rule.variables, rule.body, rule.unequal, first)
                for step in steps:
                    self._indices.setdefault(step.index[0], {}).setdefault(step.index[1], {})
                self._watchers.setdefault(str(rule.body[first][0]), []).append((rule, steps))

    def start(self) -> None:
        """Report the rules without conditions, which no fact triggers."""
        for rule in self._empty:
            rule.on_match(())

    def add(self, fact: Fact) -> None:
        """Add a fact, if it is new, and report every match that it completes."""
        if fact in self.facts or fact[0] not in self._indices:
            return
        self.facts[fact] = None
        self._queue.append(fact)
        if self._busy:
            return
        self._busy = True
        try:
            while self._queue:
                self._insert(self._queue.popleft())
        finally:
            self._busy = False

    def _insert(self, fact: Fact) -> None:
        for positions, table in self._indices.get(fact[0], {}).items():
            table.setdefault(tuple(fact[p] for p in positions), []).append(fact)
        for rule, steps in self._watchers.get(fact[0], ()):
            slots = [-1] * len(rule.variables)
            matches: list[tuple[int, ...]] = []
            first = steps[0]
            if all(fact[p] == value for p, (_, value) in zip(first.index[1], first.key, strict=True)):
                self._bind(fact, first, steps, 0, slots, fact, matches)
            for match in matches:
                rule.on_match(match)

    def _bind(
        self,
        candidate: Fact,
        step: Step,
        steps: tuple[Step, ...],
        depth: int,
        slots: list[int],
        trigger: Fact,
        matches: list[tuple[int, ...]],
    ) -> None:
        for position, slot in step.binds:
            slots[slot] = candidate[position]
        for position, slot in step.repeats:
            if candidate[position] != slots[slot]:
                return
        for a, b in step.unequal:
            if (slots[a] if a >= 0 else -a - 1) == (slots[b] if b >= 0 else -b - 1):
                return
        depth += 1
        if depth == len(steps):
            matches.append(tuple(slots))
            return
        following = steps[depth]
        key = tuple([slots[value] if is_slot else value for is_slot, value in following.key])
        table = self._indices[following.index[0]][following.index[1]]
        # A fact that matches several positions of one body is the trigger of the first of them only.
        earlier = following.position < steps[0].position
        for fact in table.get(key, ()):
            if not (earlier and fact == trigger):
                self._bind(fact, following, steps, depth, slots, trigger, matches)
