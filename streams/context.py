"""What a sampler receives first: what the planner's own context fits, and one for samples that are kept."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import numpy as np


class Context(Protocol):
    """What a sampler receives first. The planner's own context fits; a test may pass any object that does.

    Attributes:
        scene: the workspace.
        seed: of the search; what is kept for all searches of a run is drawn for a seed.
        rng: a generator derived from (seed, stream, inputs), so that samples do not depend on the order of calls.
        deadline: when to stop, on the clock of tamp.clock.now() [s].
        fluents: facts that hold where the output will be used, for streams with `:fluents`.
        bound: facts that the plan under construction has already settled.
        brief: whether no plan waits for an output, so that a sampler that works long may pause now and then.
    """

    @property
    def scene(self) -> Any: ...  # noqa: D102
    @property
    def seed(self) -> int: ...  # noqa: D102
    @property
    def rng(self) -> np.random.Generator: ...  # noqa: D102
    @property
    def deadline(self) -> float: ...  # noqa: D102
    @property
    def fluents(self) -> Any: ...  # noqa: D102
    @property
    def bound(self) -> Any: ...  # noqa: D102
    @property
    def brief(self) -> bool: ...  # noqa: D102

    def fail(self, reason: str, because: Any = (), proven: bool = True) -> None:
        """Say why nothing comes: a reason for the report and, where known, the facts that suffice for it.

        `proven`: False where more tries might have found something.
        """

    def pause(self) -> None:
        """Say that the None that is yielded next stands for work without an output yet."""


@dataclass
class Detached:
    """A context that knows no plan and no deadline: what is drawn with it serves every search.

    Attributes:
        scene: the part of the workspace that the samples may depend on.
        seed: of the search.
        rng: source of every random choice.
    """

    scene: Any
    seed: int
    rng: np.random.Generator
    deadline: float = math.inf
    fluents: tuple[Any, ...] = ()
    bound: tuple[Any, ...] = ()
    brief: bool = False
    reasons: list[str] = field(default_factory=list)

    def fail(self, reason: str, because: Any = (), proven: bool = True) -> None:
        """Remember a reason, for all who ask."""
        self.reasons.append(reason)

    def pause(self) -> None:
        """Nothing: who draws with it waits for an output."""

    @staticmethod
    def of(context: Context, deadline: float = math.inf) -> Detached:
        """One with the same scene and a generator of its own, for a part of a sampler's work that shall go unheard."""
        return Detached(context.scene, context.seed, context.rng.spawn(1)[0], deadline)
