"""The end of a command whose samplers let nobody interrupt them."""

from __future__ import annotations

import argparse
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

from tamp.cli.output import write_json
from tamp.clock import watched

LATE_S = 0.9
"""How long after the limit planning may go on before the process is ended [s]."""


@dataclass(frozen=True)
class LastWords:
    """What a command leaves that is ended by force.

    Attributes:
        status: its exit status.
        sentence: for standard error.
        data: for the file of `--json`.
    """

    status: int
    sentence: str
    data: Mapping[str, Any]

    def say(self, options: argparse.Namespace) -> int:
        """Tell the user, and return the exit status."""
        print(self.sentence, file=sys.stderr, flush=True)
        write_json(options, self.data)
        options.out.flush()
        return self.status


@contextmanager
def ended_by_force(options: argparse.Namespace, words: LastWords) -> Iterator[None]:
    """End the process where planning inside the block goes on past its limit and cannot be interrupted.

    The process that waits for it (`apart`) does that, since native code may keep all threads of this one from running;
    a thread where nobody waits.
    """
    watch = _by_thread(partial(_end, options, words)) if options.line is None else partial(options.line.tell, words)
    with watched(watch):
        yield


def _by_thread(end: Callable[[], None]) -> Callable[[float | None], None]:
    timers: list[threading.Timer] = []

    def watch(until: float | None) -> None:
        while timers:
            timers.pop().cancel()
        if until is not None:
            timers.append(threading.Timer(until + LATE_S - time.monotonic(), end))
            timers[0].daemon = True
            timers[0].start()

    return watch


def _end(options: argparse.Namespace, words: LastWords) -> None:
    os._exit(words.say(options))
