"""An attempt to bind a skeleton: what it may spend, and what came of it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace

from tamp.planning.model.external import External
from tamp.planning.model.normal_form import ActionSchema
from tamp.planning.model.objects import Fact
from tamp.planning.model.state import State
from tamp.planning.model.stream_instances import Instance


@dataclass(frozen=True)
class Budget:
    """How much one attempt may spend: counts, so that the outcome does not depend on the machine's load.

    Attributes:
        values: values tried for one choice before it is given up.
        draws: calls of streams with outputs in the whole attempt, on top of four for each item of the skeleton.
        patience: draws in a row that may bring nothing before a choice is given up.
        jumps: failed checks in the whole attempt.
        barren: values that say little of others which may be tried for one choice on top of those.
    """

    values: int = 6
    draws: int = 60
    patience: int = 6
    jumps: int = 1000
    barren: int = 24

    def grown(self, attempts: int) -> Budget:
        """The budget after some failed attempts: each doubles it, up to a bound."""
        factor = 2 ** min(attempts, 6)
        counts = (self.values, self.draws, self.patience, self.jumps, self.barren)
        return Budget(*(count * factor for count in counts))


@dataclass(frozen=True)
class BoundStep:
    """An action with real objects for all variables of its condition."""

    schema: ActionSchema
    binding: dict[str, int]

    @property
    def args(self) -> tuple[int, ...]:
        """Handles of the action's own parameters."""
        return tuple(self.binding[t] if isinstance(t, str) else t for t in self.schema.parameters)


@dataclass(frozen=True)
class FailedMove:
    """A move between two values for which a stream had nothing to give.

    Attributes:
        facts: the cause, as its sampler named it, or as was `guessed`; empty where nothing is known.
    """

    source: int
    target: int
    facts: tuple[Fact, ...]
    guessed: bool = False

    def without(self, wanted: Collection[Fact]) -> FailedMove:
        """A move whose cause is guessed, without what must hold where it leads to: that is not in the way."""
        return replace(self, facts=tuple(f for f in self.facts if f not in wanted)) if self.guessed else self


@dataclass(frozen=True)
class Nogood:
    """A stream has nothing to give for some inputs.

    Attributes:
        facts: where they hold it has nothing; a guess but where its sampler `named` them.
        told: all that it was told.
    """

    external: External
    inputs: tuple[int, ...]
    facts: tuple[Fact, ...]
    named: bool
    told: tuple[Fact, ...]


@dataclass
class Attempt:
    """What came of binding a skeleton.

    Attributes:
        steps: the bound actions, connectors included; None where it failed.
        values: placeholder -> what it stands for in them.
        blamed: real instances whose values all led to conflicts.
        moves: moves between actions that failed.
        moved: the values to which moves led, each with what held then.
        nogoods: streams that failed in a state.
        barred: facts that were not to hold, each with what made it hold.
        broke_at, reason: where it got furthest, and why not further.
        depth: the number of that item.
    """

    steps: tuple[BoundStep, ...] | None = None
    values: dict[int, int] = field(default_factory=dict)
    blamed: dict[Instance, None] = field(default_factory=dict)
    moves: list[FailedMove] = field(default_factory=list)
    moved: list[tuple[int, State]] = field(default_factory=list)
    nogoods: list[Nogood] = field(default_factory=list)
    barred: dict[Fact, tuple[Fact, ...]] = field(default_factory=dict)
    broke_at: str = ""
    reason: str = ""
    depth: int = -1


@dataclass
class Frame:
    """The choice of one item: which instance, which of its results, and what made earlier values fail.

    Attributes:
        visits: how often it was begun anew, with other choices before it.
        known: how many results its instance had then.
        barren: how many of the values tried were such that a stream which goes on from them had nothing to give.
        barred: how many of them were such that a test was against them, or against all that was made of them.
        parents: how many earlier choices gave its inputs.
        vain: how many visits in a row ended with no value left to try, up to the last one.
        ended: whether this one did.
    """

    instance: Instance | None = None
    cursor: int = 0
    tried: int = 0
    visits: int = 0
    known: int = 0
    barren: int = 0
    barred: int = 0
    parents: int = 0
    vain: int = 0
    ended: bool = False
    conflict: set[int] = field(default_factory=set)
    outputs: tuple[int, ...] = ()
    moves: tuple[BoundStep, ...] = ()
    culprits: dict[Instance, None] = field(default_factory=dict)
