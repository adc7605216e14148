"""What moves have failed for: a reluctance to use their values again while the same is in the way."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from tamp.planning.grounding.atom_table import Numbering
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact

LIKE = 4
"""How many moves to values that came from the same streams a fact bars before it is taken to bar the others."""


@dataclass
class Blame:
    """A learnt reluctance: an operator that mentions a value is discouraged while one of `facts` holds.

    Attributes:
        facts: what was named or guessed to be in the way, each with how often.
        failures: how many moves to the value failed, or plans with values of the lineage that it stands for.
        harmless: what held when a move to the value succeeded, each with how often.
        kinds: facts that bar all values of a lineage, with lineages in place of objects, each with how often.
    """

    facts: Counter[Fact] = field(default_factory=Counter)
    failures: int = 0
    harmless: Counter[Fact] = field(default_factory=Counter)
    kinds: Counter[Fact] = field(default_factory=Counter)

    @property
    def weight(self) -> int:
        """What it adds to the cost of an operator."""
        return 30 * self.failures

    def of_all(self) -> Blame | None:
        """What bars most moves to some values, and so maybe to others of their like; None where nothing does."""
        common = Counter({f: n for f, n in self.facts.items() if n >= LIKE and n > self.harmless[f]})
        return Blame(common, self.failures, kinds=self.kinds) if common or self.kinds else None


class Reluctance:
    """Why what needs some values is discouraged: because of them, or of most of their like.

    Attributes:
        weight: what it adds to a cost. What failed itself weighs more than what is only like it.
        vague: whether something failed for a reason that is not known.
    """

    def __init__(self, handles: Iterable[int], blames: Mapping[int, Blame], knowledge: Knowledge) -> None:
        self._own: list[Blame] = []
        self._all: list[Blame] = []
        if blames:
            values = dict.fromkeys(handles)
            kinds = dict.fromkeys(map(knowledge.lineage, values)).keys() - values.keys()
            like = (blames[kind].of_all() for kind in sorted(kinds) if kind in blames)
            self._own = [blames[value] for value in values if value in blames]
            self._all = [*self._own, *(blame for blame in like if blame is not None)]
        self.weight = sum(blame.weight for blame in self._all)
        self.vague = not all(blame.facts or blame.kinds for blame in self._all)

    def barring(self, kept: Collection[Fact], number: Numbering) -> list[Fact]:
        """The facts within reach, but for those to be kept, that were in the way."""
        named = dict.fromkeys(f for blame in self._all for f in (*blame.facts, *number.of_kinds(blame.kinds)))
        return [f for f in named if f not in kept and number.known(f)]

    def spoilt(self, kept: Collection[Fact]) -> bool:
        """Whether what is to be kept was itself in the way of one of the values."""
        return any(fact in kept for blame in self._own for fact in blame.facts)
