"""Joins of conjunctive conditions over facts, in an order that keeps them small."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from heapq import heappop, heappush

from tamp.planning.model.objects import Fact, Pattern

EVERY = 200
"""Matches between two ticks."""


@dataclass(frozen=True)
class Step:
    """Looks up one pattern of a body when some of its variables are bound already."""

    position: int
    index: tuple[str, tuple[int, ...]]
    key: tuple[tuple[bool, int], ...]  # (is a slot, slot or handle) for each indexed position
    binds: tuple[tuple[int, int], ...]  # (position in the fact, slot)
    repeats: tuple[tuple[int, int], ...]
    unequal: tuple[tuple[int, int], ...]


@lru_cache(maxsize=4096)
def join_order(
    variables: tuple[str, ...], body: tuple[Pattern, ...], unequal: tuple[tuple[str | int, str | int], ...], first: int
) -> tuple[Step, ...]:
    """The order in which to look a body up from pattern `first` on: next the one with the fewest unbound variables.

    One that shares a variable with those before it comes first: others multiply what is looked at, to be joined by
    nothing yet. A pattern that any object fits comes last: by then another one may have bound its variable. Answers are
    kept, as replanning asks for the same rules again and again.
    """
    slot = {variable: i for i, variable in enumerate(variables)}
    bound: set[str] = set()
    rest = list(range(len(body)))
    open_pairs = list(unequal)
    steps: list[Step] = []
    while rest:
        position = first if not steps else min(rest, key=lambda i: _openness(body[i], bound))
        rest.remove(position)
        ready = frozenset(t for t in body[position][1:] if isinstance(t, str)) | bound
        pairs = [pair for pair in open_pairs if all(isinstance(t, int) or t in ready for t in pair)]
        open_pairs = [pair for pair in open_pairs if pair not in pairs]
        steps.append(
            _step(body[position], position, slot, bound, tuple((_code(a, slot), _code(b, slot)) for a, b in pairs))
        )
        bound |= ready
    return tuple(steps)


def _step(
    pattern: Pattern, position: int, slot: dict[str, int], bound: set[str], unequal: tuple[tuple[int, int], ...]
) -> Step:
    positions: list[int] = []
    key: list[tuple[bool, int]] = []
    binds: dict[int, int] = {}
    repeats: list[tuple[int, int]] = []
    for i, term in enumerate(pattern[1:], start=1):
        if isinstance(term, int):
            positions.append(i)
            key.append((False, term))
        elif term in bound:
            positions.append(i)
            key.append((True, slot[term]))
        elif slot[term] in binds.values():
            repeats.append((i, slot[term]))
        else:
            binds[i] = slot[term]
    index = (str(pattern[0]), tuple(positions))
    return Step(position, index, tuple(key), tuple(binds.items()), tuple(repeats), unequal)


def _openness(pattern: Pattern, bound: set[str]) -> tuple[bool, bool, int]:
    variables = {term for term in pattern[1:] if isinstance(term, str)}
    unbound = len(variables - bound)
    return pattern[0] == "object" and unbound > 0, 0 < unbound == len(variables), unbound


def _code(term: str | int, slot: dict[str, int]) -> int:
    """A slot as itself, a handle as a negative number."""
    return -term - 1 if isinstance(term, int) else slot[term]


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
    """Facts and the rules they feed. Facts may be added from within `on_match`.

    Attributes:
        tick: called now and then; it may end the work by an exception.
        paused: whether matches shall wait for a later `run`; asked after each of them.
        broken: whether the work was ended by an exception, so that matches are missing.
    """

    def __init__(self, rules: Sequence[JoinRule]) -> None:
        self.facts: dict[Fact, None] = {}
        self._queue: list[tuple[int, int, Fact]] = []  # a heap: turn, then first come, first served
        self._matches: Iterator[tuple[JoinRule, tuple[int, ...]]] | None = None
        self._busy = False
        self.broken = False
        self._indices: dict[str, dict[tuple[int, ...], dict[tuple[int, ...], list[Fact]]]] = {}
        self._watchers: dict[str, list[tuple[JoinRule, tuple[Step, ...]]]] = {}
        self._empty = [rule for rule in rules if not rule.body]
        self.tick: Callable[[], None] = lambda: None
        self.paused: Callable[[], bool] = lambda: False
        self._since_tick = 0
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

    def add(self, fact: Fact, turn: int = 0) -> None:
        """Add a fact, if it is new, and report every match that it completes.

        `turn`: where facts wait, those with the lowest come first.
        """
        if fact in self.facts or fact[0] not in self._indices:
            return
        self.facts[fact] = None
        heappush(self._queue, (turn, len(self.facts), fact))
        self.run()

    def remove(self, fact: Fact) -> None:
        """Let a fact complete no matches from now on, unless it is added again."""
        if self.facts.pop(fact, 0) is None:
            for positions, table in self._indices[fact[0]].items():
                key = tuple(fact[p] for p in positions)
                table[key] = [f for f in table.get(key, ()) if f != fact]  # another list: that one may be being read

    @property
    def unfinished(self) -> bool:
        """Whether matches wait."""
        return bool(self._queue) or self._matches is not None

    def run(self) -> None:
        """Report the matches that wait, until there are none or there shall be a pause."""
        if self._busy:
            return
        self._busy = self.broken = True
        try:
            while self.unfinished and not self.paused():
                if self._matches is None:
                    self._matches = self._insert(heappop(self._queue)[2])
                for rule, match in self._matches:
                    self._count()
                    rule.on_match(match)
                    if self.paused():
                        break
                else:
                    self._matches = None
            self.broken = False
        finally:
            self._busy = False

    def _insert(self, fact: Fact) -> Iterator[tuple[JoinRule, tuple[int, ...]]]:
        """The matches that a fact completes, looked up as they are asked for; no other is inserted meanwhile."""
        for positions, table in self._indices.get(fact[0], {}).items():
            table.setdefault(tuple(fact[p] for p in positions), []).append(fact)
        for rule, steps in self._watchers.get(fact[0], ()):
            slots = [-1] * len(rule.variables)
            first = steps[0]
            if not all(fact[p] == value for p, (_, value) in zip(first.index[1], first.key, strict=True)):
                continue
            if not self._take(fact, first, slots):
                continue
            if len(steps) == 1:
                yield rule, tuple(slots)
                continue
            for candidate in self._candidates(steps, 1, slots, fact):
                matches: list[tuple[int, ...]] = []
                self._bind(candidate, steps, 1, slots, fact, matches)
                for match in matches:
                    yield rule, match

    def _count(self) -> None:
        self._since_tick += 1
        if self._since_tick >= EVERY:
            self._since_tick = 0
            self.tick()

    def _bind(
        self,
        candidate: Fact,
        steps: tuple[Step, ...],
        depth: int,
        slots: list[int],
        trigger: Fact,
        matches: list[tuple[int, ...]],
    ) -> None:
        if not self._take(candidate, steps[depth], slots):
            return
        if depth + 1 == len(steps):
            matches.append(tuple(slots))
            return
        for fact in self._candidates(steps, depth + 1, slots, trigger):
            self._bind(fact, steps, depth + 1, slots, trigger, matches)

    def _take(self, candidate: Fact, step: Step, slots: list[int]) -> bool:
        """Bind what a fact says of a step's variables; whether it fits."""
        for position, slot in step.binds:
            slots[slot] = candidate[position]
        for position, slot in step.repeats:
            if candidate[position] != slots[slot]:
                return False
        return not step.unequal or all(
            (slots[a] if a >= 0 else -a - 1) != (slots[b] if b >= 0 else -b - 1) for a, b in step.unequal
        )

    def _candidates(self, steps: tuple[Step, ...], depth: int, slots: list[int], trigger: Fact) -> Sequence[Fact]:
        step = steps[depth]
        key = tuple([slots[value] if is_slot else value for is_slot, value in step.key])
        found = self._indices[step.index[0]][step.index[1]].get(key, ())
        # A fact that matches several positions of one body is the trigger of the first of them only.
        if step.position < steps[0].position and trigger[0] == step.index[0]:
            return [fact for fact in found if fact != trigger]
        return found
