"""In which order the literals of a condition are looked up, worked out once for all bindings of the same variables."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from tamp.planning.normal_schemas import Condition
from tamp.planning.objects import Pattern
from tamp.planning.schema import Schema

Pairs = tuple[tuple[str | int, str | int], ...]


@dataclass(frozen=True)
class Lookup:
    """One literal's turn.

    Attributes:
        pattern: the literal.
        known: positions of its terms that are bound by then.
        open: positions and variables of the others.
        unequal: the inequalities that can be decided after it.
    """

    pattern: Pattern
    known: tuple[int, ...]
    open: tuple[tuple[int, str], ...]
    unequal: Pairs = ()

    @classmethod
    def of(cls, pattern: Pattern, bound: Collection[str], unequal: Pairs = ()) -> Lookup:
        """The turn of a literal by which the variables `bound` have values."""
        terms = list(enumerate(pattern))[1:]
        free = tuple((i, t) for i, t in terms if isinstance(t, str) and t not in bound)
        return cls(pattern, tuple(i for i, t in terms if isinstance(t, int) or t in bound), free, unequal)

    def key(self, binding: dict[str, int]) -> tuple[int, ...]:
        """The handles at the known positions."""
        return tuple([binding[t] if isinstance(t := self.pattern[i], str) else t for i in self.known])


@dataclass(frozen=True)
class Lookups:
    """A condition in the order of evaluation.

    Attributes:
        condition: the condition.
        unequal: its inequalities that can be decided at once.
        positive: the turns of its positive literals.
        negative: its negative literals, tests last.
    """

    condition: Condition
    unequal: Pairs
    positive: tuple[Lookup, ...]
    negative: tuple[Pattern, ...]


def order(condition: Condition, bound: Collection[str], schema: Schema) -> Lookups:
    """A condition's lookups where the variables `bound` have values: cheap and selective ones first."""
    rest, pairs, known = list(condition.positive), list(condition.unequal), set(bound)

    def ready() -> Pairs:
        found = tuple(pair for pair in pairs if all(isinstance(t, int) or t in known for t in pair))
        pairs[:] = [pair for pair in pairs if pair not in found]
        return found

    first = ready()
    turns: list[Lookup] = []
    while rest:
        pattern = min(rest, key=lambda p: _rank(p, known, schema))
        rest = [p for p in rest if p is not pattern]
        before = frozenset(known)
        known |= {t for t in pattern[1:] if isinstance(t, str)}
        turns.append(Lookup.of(pattern, before, ready()))
    negative = sorted(condition.negative, key=lambda p: p[0] in schema.tests)
    return Lookups(condition, first, tuple(turns), tuple(negative))


def _rank(pattern: Pattern, bound: Collection[str], schema: Schema) -> tuple[int, int]:
    """Cheap and selective literals first, tests last."""
    unbound = sum(isinstance(t, str) and t not in bound for t in pattern[1:])
    if pattern[0] in schema.tests:
        return (9 if not unbound else 10), unbound
    if not unbound and pattern[0] not in schema.derived:
        return 0, 0
    kind = 1 if pattern[0] in schema.fluents else 2 if pattern[0] not in schema.derived else 3
    return 1 + (pattern[0] == "object") * 7, unbound * 10 + kind


def differ(pairs: Pairs, binding: dict[str, int]) -> bool:
    """Whether the two sides of each inequality have different values."""
    return all((binding[a] if isinstance(a, str) else a) != (binding[b] if isinstance(b, str) else b) for a, b in pairs)
