"""What a run may spend: time, searches and memory."""

from __future__ import annotations

import math
import resource
import time
from pathlib import Path

from tamp.planning.options import Ended, Options


class Limits:
    """Counts searches, and ends the run where a limit is reached.

    Attributes:
        deadline: when the run must end, on the clock of time.monotonic [s].
    """

    def __init__(self, options: Options, started: float) -> None:
        self.deadline = started + options.timeout
        self.iterations = 0
        self._options = options

    @property
    def left(self) -> float:
        """How much time is left [s]."""
        return self.deadline - time.monotonic()

    def check(self) -> None:
        """End the run where a limit is reached.

        Raises:
            Ended: with the status to report.
        """
        options = self._options
        if self.left <= 0.0:
            raise Ended("timeout", f"The time limit of {options.timeout:g} s was reached.")
        if self.iterations >= options.max_iterations:
            raise Ended("failed", f"The limit of {options.max_iterations} iterations was reached.")
        if options.max_memory < math.inf and resident_mb() >= options.max_memory:
            raise Ended("failed", f"The memory limit of {options.max_memory:g} MB was reached.")


def resident_mb() -> float:
    """How much memory this process holds now [MB]; as far as the system does not say, the most that it ever held."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except FileNotFoundError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return pages * resource.getpagesize() / 1e6
