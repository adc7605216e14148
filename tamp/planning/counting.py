"""How samplers did: calls, successes, time, and the reasons they gave for failures."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from tamp.planning.report import StreamReport


@dataclass
class Count:
    """The calls of one stream.

    Attributes:
        calls: how many there were.
        successes: how many gave something.
        seconds: real time spent in them [s].
        failures: reason -> how often it was given.
    """

    calls: int = 0
    successes: int = 0
    seconds: float = 0.0
    failures: Counter[str] = field(default_factory=Counter)

    @contextmanager
    def calling(self) -> Iterator[None]:
        """Counts and times one call."""
        self.calls += 1
        before = time.perf_counter()
        try:
            yield
        finally:
            self.seconds += time.perf_counter() - before

    def report(self, name: str) -> StreamReport:
        """The counts for the report, the most frequent reason first."""
        reasons = tuple(sorted(self.failures.items(), key=lambda item: (-item[1], item[0])))
        return StreamReport(name, self.calls, self.successes, self.seconds, reasons)
