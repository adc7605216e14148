"""Stream instances, and what is known: certified facts, and optimistic facts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from tamp.planning.context import Context
from tamp.planning.model.external import External
from tamp.planning.model.objects import Fact, Pattern

LEAST_ODDS = 0.02
"""The least success that is ever expected of a call."""

IN_VAIN = 60
"""Calls without a success after which more of their kind are hardly worth a try."""

SUSPECTED = 8
"""Inputs for which there is nothing in a state after which none is expected in it for others of their kind."""


@dataclass(eq=False, slots=True)
class Record:
    """How calls of a stream went whose inputs came from the same streams.

    What one of them fails for, such as that no pose of a region can be reached, the others mostly fail for as well.

    Attributes:
        refused: facts where they held there was nothing -> for how many inputs; minus infinity where that is disproved.
    """

    calls: int = 0
    successes: int = 0
    refused: dict[tuple[Fact, ...], float] = field(default_factory=dict)

    def refuse(self, facts: tuple[Fact, ...]) -> None:
        """Count inputs for which there was nothing where some facts held, for no reason that was named."""
        self.refused[facts] = self.refused.get(facts, 0.0) + 1.0

    def acquit(self, told: tuple[Fact, ...]) -> None:
        """Note that there was something where these facts held: they are not why others failed."""
        for facts in self.refused:
            if set(facts).issubset(told):
                self.refused[facts] = -math.inf

    @property
    def suspects(self) -> Iterator[tuple[Fact, ...]]:
        """What held where there was nothing for so many inputs that there may be nothing for any others."""
        return (facts for facts, count in self.refused.items() if count >= SUSPECTED)

    @property
    def odds(self) -> float:
        """The success to expect of the next call, before any call 1 (a mean with two successes given in advance)."""
        return max((self.successes + 2) / (self.calls + 2), LEAST_ODDS)

    @property
    def promising(self) -> bool:
        """Whether a call has succeeded, or too few were made to tell."""
        return self.successes > 0 or self.calls < IN_VAIN

    @property
    def unfailing(self) -> bool:
        """Whether all calls have succeeded, and there were enough to tell."""
        return self.successes == self.calls >= IN_VAIN


@dataclass(eq=False, slots=True)
class Instance:
    """A stream applied to inputs, and everything that happened to it.

    Attributes:
        level: how many streams in a row its outputs need that were not called yet.
        placeholders: its optimistic outputs.
        supports: the instances that its inputs and domain facts assume.
        results: what it has yielded, in order; for a test `[()]` where it holds.
        activated: numbers of the results that the search may use.
        failures: attempts to bind a plan that blamed it.
        exhausted: whether it has ended.
        gave_up: whether it said that its end is no proof that there is nothing more.
        nogoods: for a stream with fluents, sets of facts in which it has nothing to give, each with whether its sampler
            said that they are why; otherwise that is a guess.
        refusals: all that it was told where the reason is a guess.
        record: how calls went, shared by all instances whose inputs came from the same streams.
    """

    external: External
    inputs: tuple[int, ...]
    fluents: tuple[Fact, ...] = ()
    level: int = 1
    placeholders: tuple[int, ...] = ()
    supports: tuple[Instance, ...] = ()
    domain: tuple[Fact, ...] = ()
    results: list[tuple[int, ...]] = field(default_factory=list)
    reasons: dict[tuple[str, tuple[Fact, ...]], int] = field(default_factory=dict)
    activated: set[int] = field(default_factory=set)
    failures: int = 0
    nogoods: dict[tuple[Fact, ...], bool] = field(default_factory=dict)
    refusals: dict[tuple[Fact, ...], None] = field(default_factory=dict)
    record: Record = field(default_factory=Record)
    calls: int = 0
    exhausted: bool = False
    gave_up: bool = False
    alive: bool = True
    context: Context | None = None
    generator: Iterator[Any] | None = None

    def binding(self, outputs: tuple[int, ...] = ()) -> dict[str, int]:
        """Variables of the stream -> handles."""
        external = self.external
        return dict(zip((*external.inputs, *external.outputs), (*self.inputs, *outputs), strict=False))

    def certified(self, outputs: tuple[int, ...]) -> tuple[Fact, ...]:
        """What it certifies of its inputs and these outputs."""
        binding = self.binding(outputs)
        return tuple(ground(pattern, binding) for pattern in self.external.certified)

    def outputs_with(self, handle: int) -> tuple[int, ...]:
        """The first of its results that has an object among its outputs; none where there is no such result."""
        return next((outputs for outputs in self.results if handle in outputs), ())

    @property
    def main_reason(self) -> tuple[str, tuple[Fact, ...]]:
        """The reason that its sampler gave most often, and the facts that it named."""
        return max(self.reasons, key=lambda key: self.reasons[key], default=("nothing more to give", ()))

    @property
    def unfinished(self) -> bool:
        """Whether it may have values that the search does not know."""
        return not self.exhausted or len(self.activated) < len(self.results)

    @property
    def effort(self) -> float:
        """How reluctantly the search should use it."""
        info = self.external.info
        return info.cost / max(info.p_success * self.record.odds, 0.001) + 60.0 * self.failures


def ground(pattern: Pattern, binding: dict[str, int]) -> Fact:
    """A pattern with its variables replaced."""
    return (pattern[0], *[binding[t] if isinstance(t, str) else t for t in pattern[1:]])
