"""Whose turn it is, where wild streams bring more than can all be looked at: fair queueing by kind."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from operator import attrgetter, itemgetter

from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import Instance


class Turns:
    """Gives facts and stream instances of each kind their turn (fair queueing; Nagle 1987).

    Instances are of one kind that are of one stream, for inputs that came from instances of the same kinds. What a wild
    stream brings came from it as well: the edges between the thousand vertices of a roadmap are a single kind, beside
    the one edge between two values that a plan needs. A turn is a number, the lowest comes first: how many of its kind
    came before, and how many streams in a row are behind it. Of each depth there are finitely many kinds, so that
    everything has its turn sooner or later.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._kinds: dict[tuple[str, tuple[int, ...]], int] = {}  # below 0; an object of the problem is its own
        self._kind_of: dict[int, int] = {}
        self._depths: dict[int, int] = {}
        self._facts: Counter[tuple[int | str, ...]] = Counter()

    @property
    def needed(self) -> bool:
        """Whether wild streams have brought objects; otherwise what comes first has the first turn."""
        return bool(self._knowledge.bringers)

    def of_fact(self, fact: Fact) -> int:
        """The turn of a fact, counted after those of its kind that were asked about before."""
        kinds = tuple(map(self._origin, fact[1:]))
        alike = (fact[0], *kinds)
        self._facts[alike] += 1
        return self._facts[alike] + max((self._depths.get(kind, 0) for kind in kinds), default=0)

    def in_turn(self, instances: Iterable[Instance]) -> list[Instance]:
        """The instances that have more to give, by turns; those before it are the calls of its kind.

        Of several that have the same turn those come first of whose kind there are fewest: each of them is the more
        likely to be the one that matters.
        """
        served: Counter[int] = Counter()
        members: list[tuple[Instance, int]] = []
        for instance in sorted(instances, key=attrgetter("calls")):
            kind = self._kind(instance.external.name, instance.inputs)
            served[kind] += instance.calls
            if instance.unfinished:
                members.append((instance, kind))
        waiting = Counter(kind for _, kind in members)
        turns: list[tuple[int, int, Instance]] = []
        for instance, kind in members:
            turns.append((served[kind] + self._depths[kind], waiting[kind], instance))
            served[kind] += 1
        return [instance for *_, instance in sorted(turns, key=itemgetter(0, 1))]

    def _kind(self, stream: str, inputs: tuple[int, ...]) -> int:
        key = (stream, tuple(map(self._origin, inputs)))
        kind = self._kinds.setdefault(key, -1 - len(self._kinds))
        self._depths[kind] = 1 + max((self._depths.get(k, 0) for k in key[1]), default=0)
        return kind

    def _origin(self, handle: int) -> int:
        """The kind of the instance that an object came from, or that a placeholder may come from."""
        if handle not in self._kind_of:
            self._kind_of[handle] = handle  # a stream may give what it was called for
            knowledge = self._knowledge
            source = knowledge.source(handle) or knowledge.bringers.get(handle) or knowledge.objects.origin(handle)
            if source is not None:
                self._kind_of[handle] = self._kind(source.external.name, source.inputs)
        return self._kind_of[handle]
