"""What a sampler receives first: the scene, its own random generator, the deadline, and what the plan has settled.

Beside it, what a sampler may give that is more than its outputs.
"""

from __future__ import annotations

import hashlib
import reprlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np


class Context:
    """The first argument of every sampler; one for each stream and inputs, alive as long as its generator.

    Attributes:
        scene: what the problem was given as its scene.
        seed: of the search, from which `rng` is derived; for samplers that keep what they draw for several searches.
        deadline: when planning must end, on the clock of tamp.clock.now() [s].
        fluents: for a stream or test with `:fluents`, the facts of those predicates at the point of the plan where the
            output or answer is used: first what never changes, then the others in the order in which they became true.
        sees_fluents: whether the stream has `:fluents` at all; there may be times when none of them holds.
        bound: fluent facts that hold in the plan while this output will be in use, as far as they are settled: first
            those of later states, last those that hold at once. Advice only: it changes between two outputs.
        brief: whether no plan waits for this output, as all streams are drawn from in turn. A sampler that works long
            without one may then `pause` now and then, and goes on when it is asked again.
        paused: whether it has.
    """

    def __init__(
        self,
        scene: Any,
        rng: Callable[[], np.random.Generator],
        deadline: float,
        fluents: tuple[Any, ...] | None = None,
        seed: int = 0,
    ) -> None:
        """`fluents`: None for a stream that has none."""
        self.scene = scene
        self.seed = seed
        self._make_rng = rng
        self.deadline = deadline
        self.fluents = fluents or ()
        self.sees_fluents = fluents is not None
        self.bound: tuple[Any, ...] = ()
        self.brief = self.paused = False
        self.failures: list[tuple[str, tuple[Any, ...]]] = []
        self.gave_up = False

    @cached_property
    def rng(self) -> np.random.Generator:
        """A random generator derived from (seed, stream, inputs), whatever the order of calls."""
        return self._make_rng()

    def fail(self, reason: str, because: Iterable[Any] = (), proven: bool = True) -> None:
        """Say why nothing comes, or why a test says no.

        Args:
            reason: for the report, in a few words, the same for the same cause.
            because: the facts of `fluents` that suffice for the failure, so that the planner can change just those.
            proven: False where this is no proof, as after a number of tries: no problem is called infeasible for it.

        Raises:
            TypeError: where the reason is no text, or what shall suffice are no facts.
        """
        if not isinstance(reason, str):
            raise TypeError(f"context.fail takes a reason in words, found {reprlib.repr(reason)}")
        facts: tuple[Any, ...] = tuple(because) if isinstance(because, Iterable) else (because,)
        for fact in facts:
            if not (isinstance(fact, tuple | list) and fact and isinstance(fact[0], str)):
                valid = 'a list of facts such as ("AtPose", obj, placement)'
                raise TypeError(f"context.fail takes {valid} as because, found {reprlib.repr(because)}")
        self.failures.append((reason, facts))
        self.gave_up |= not proven

    def pause(self) -> None:
        """Say that the None that is yielded next is no failure: there was work without an output, and more is left."""
        self.paused = True


@dataclass(frozen=True)
class Certified:
    """What a sampler yields to certify more than its stream promises.

    A stream that may do so yields all its outputs like this, from the first on: without it, a problem may be taken for
    infeasible that only further facts could save.

    Attributes:
        outputs: the outputs as it would otherwise yield them; None to certify facts alone.
        facts: further facts about any values. Those that actions change are taken to hold from the start.
    """

    outputs: Any
    facts: tuple[tuple[Any, ...], ...] = ()


def generator_for(seed: int, stream: str, inputs: Iterable[str]) -> np.random.Generator:
    """The random generator of a stream for inputs with these keys: the same in every process."""
    text = "\x1f".join((str(seed), stream, *inputs))
    digest = hashlib.blake2b(text.encode(), digest_size=16).digest()
    return np.random.default_rng(int.from_bytes(digest, "little"))
