"""The end of a command whose samplers let nobody interrupt them."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tamp.clock import watched

LATE_S = 0.9
"""How long after the limit planning may go on before the process is ended [s]."""


@contextmanager
def ended_by_force(status: int, say: Callable[[], object]) -> Iterator[None]:
    """End the process where planning inside the block goes on past its limit and cannot be interrupted.

    Args:
        status: the exit status then.
        say: called before, to tell the user.
    """
    timers: list[threading.Timer] = []

    def end() -> None:
        say()
        sys.stderr.flush()
        os._exit(status)

    def watch(until: float | None) -> None:
        while timers:
            timers.pop().cancel()
        if until is not None:
            timers.append(threading.Timer(until + LATE_S - time.monotonic(), end))
            timers[0].daemon = True
            timers[0].start()

    with watched(watch):
        yield
