"""Facts that can be looked up by any of their positions."""

from __future__ import annotations

from collections.abc import Iterator

from tamp.planning.objects import Fact


class FactIndex:
    """Facts that can be looked up by any of their positions; indices are made when first asked for."""

    def __init__(self) -> None:
        self._facts: dict[str, dict[Fact, None]] = {}
        self._tables: dict[str, dict[tuple[int, ...], dict[tuple[int, ...], list[Fact]]]] = {}

    def __contains__(self, fact: Fact) -> bool:
        return fact in self._facts.get(fact[0], ())

    def __iter__(self) -> Iterator[Fact]:
        for facts in self._facts.values():
            yield from facts

    def add(self, fact: Fact) -> bool:
        """Add a fact; whether it is new."""
        facts = self._facts.setdefault(fact[0], {})
        if fact in facts:
            return False
        facts[fact] = None
        for positions, table in self._tables.get(fact[0], {}).items():
            table.setdefault(tuple([fact[p] for p in positions]), []).append(fact)
        return True

    def of(self, predicate: str) -> list[Fact]:
        """All facts of a predicate."""
        return list(self._facts.get(predicate, ()))

    def lookup(self, predicate: str, positions: tuple[int, ...], key: tuple[int, ...]) -> list[Fact]:
        """The facts of a predicate that have `key` at `positions`."""
        tables = self._tables.setdefault(predicate, {})
        if positions not in tables:
            tables[positions] = {}
            for fact in self._facts.get(predicate, ()):
                tables[positions].setdefault(tuple([fact[p] for p in positions]), []).append(fact)
        return tables[positions].get(key, [])
