"""Where the time goes: what each phase of a run takes, without the samplers that it calls."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from tamp.planning.sampling import Sampling


class Stopwatch:
    """Adds up the phases' times.

    Attributes:
        seconds: phase -> time spent in it [s].
    """

    def __init__(self, sampling: Sampling) -> None:
        self.seconds = {"grounding": 0.0, "search": 0.0, "binding": 0.0}
        self._sampling = sampling

    @contextmanager
    def timed(self, phase: str) -> Iterator[None]:
        """Count what is done inside to a phase."""
        sampled, before = self._sampling.seconds, time.perf_counter()
        try:
            yield
        finally:
            spent = time.perf_counter() - before - (self._sampling.seconds - sampled)
            self.seconds[phase] += spent
