"""The state at one point of a plan, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from tamp.planning.model.fact_store import FactIndex
from tamp.planning.model.objects import Fact

Support = tuple[Fact, ...]
"""Facts that together make a condition true; the tests among them that must fail are named as they are."""


@dataclass(frozen=True)
class Violation:
    """A condition that does not hold: the facts to blame, all of them where there are several causes, and a reason."""

    facts: tuple[Fact, ...]
    reason: str
    exact: bool = True


class State:
    """The fluent facts that hold at one point of a plan; derived facts are worked out once."""

    def __init__(self, facts: Iterable[Fact]) -> None:
        self.index = FactIndex()
        for fact in facts:
            self.index.add(fact)
        self.extensions: dict[str, FactIndex] = {}

    def __iter__(self) -> Iterator[Fact]:
        return iter(self.index)

    def __contains__(self, fact: Fact) -> bool:
        return fact in self.index
