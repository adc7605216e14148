"""A stream, test or predicate of the file as the planner sees it."""

from __future__ import annotations

from dataclasses import dataclass

from tamp.planning.model.objects import Pattern
from tamp.planning.problem import StreamInfo


@dataclass(frozen=True)
class External:
    """A stream, test or predicate as the planner sees it: patterns over variables named as in the file.

    Attributes:
        domain: what must hold whatever actions do, before it is called.
        awaited: the rest of its domain, which actions may bring: what it certifies holds while this does.
        guarded: what the file says that it certifies, where axioms derive that.
        optimizer: whose part it is; empty for a stream of its own.
        asks: the stream of the file whose sampler answers it, where it is a test that this gives anything.
    """

    name: str
    inputs: tuple[str, ...]
    domain: tuple[Pattern, ...]
    outputs: tuple[str, ...]
    certified: tuple[Pattern, ...]
    fluents: tuple[str, ...]
    info: StreamInfo
    is_predicate: bool = False
    awaited: tuple[Pattern, ...] = ()
    guarded: tuple[Pattern, ...] = ()
    optimizer: str = ""
    asks: External | None = None

    @property
    def sampler(self) -> str:
        """The name in the file of the stream whose sampler is called."""
        return self.name if self.asks is None else self.asks.name

    @property
    def is_test(self) -> bool:
        """Whether it only answers yes or no."""
        return not self.outputs

    @property
    def is_state_test(self) -> bool:
        """Whether its answer depends on the state: it certifies nothing for good."""
        return self.is_test and bool(self.fluents)

    @property
    def deferred(self) -> bool:
        """Whether its outputs are bound after everything else."""
        return bool(self.fluents) if self.info.defer is None else self.info.defer
