"""How far a batch is: a bar on a terminal; elsewhere, as in a log, a line a minute."""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from tamp.results import Result

PAUSE_S = 60.0
"""Time between two lines where there is no terminal [s]."""

log = logging.getLogger("tamp")


class Advance(Protocol):
    """Takes each result as it comes."""

    def __call__(self, result: Result, *, kept: bool = False) -> None:
        """Count a result, one that is kept from an earlier batch too."""


@contextmanager
def progress(total: int) -> Iterator[Advance]:
    """Say on standard error how far `total` runs are; with -q nothing, with -v a line a result."""
    if log.getEffectiveLevel() > logging.WARNING:
        yield _tell
    elif sys.stderr.isatty():
        with _bar(total) as advance:
            yield advance
    else:
        with _lines(Count(total)) as advance:
            yield advance


@dataclass
class Count:
    """Results so far."""

    total: int
    solved: int = 0
    failed: int = 0
    kept: int = 0
    began: float = field(default_factory=time.monotonic)

    def add(self, result: Result, *, kept: bool) -> None:
        """Count one."""
        self.solved += result.solved
        self.failed += not result.solved
        self.kept += kept

    def __str__(self) -> str:
        done = self.solved + self.failed
        ran, spent = done - self.kept, time.monotonic() - self.began
        left = f", about {spent / ran * (self.total - done) / 60:.0f} min left" if ran else ""
        return f"{done} of {self.total} done after {spent / 60:.0f} min: {self.solved} solved, {self.failed} not{left}"


@contextmanager
def _lines(count: Count, pause_s: float = PAUSE_S) -> Iterator[Advance]:
    """A line every minute, whether results come or not."""
    ended = threading.Event()

    def speak() -> None:
        while not ended.wait(pause_s):
            print(f"tamp: {count}", file=sys.stderr, flush=True)

    def advance(result: Result, *, kept: bool = False) -> None:
        count.add(result, kept=kept)
        _tell(result, kept=kept)

    speaker = threading.Thread(target=speak, daemon=True)
    speaker.start()
    try:
        yield advance
    finally:
        ended.set()
        speaker.join()


@contextmanager
def _bar(total: int) -> Iterator[Advance]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    counts = TextColumn("[green]{task.fields[solved]} solved[/green] [red]{task.fields[failed]} failed[/red]")
    now = TextColumn("{task.description}", markup=False)
    columns = (BarColumn(), MofNCompleteColumn(), counts, TimeRemainingColumn(), now)
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        count = Count(total)
        line = bar.add_task("", total=total, solved=0, failed=0)

        def advance(result: Result, *, kept: bool = False) -> None:
            count.add(result, kept=kept)
            said = f"{result.task} {result.status}"
            bar.update(line, advance=1, description=said, solved=count.solved, failed=count.failed)

        yield advance


def _tell(result: Result, *, kept: bool = False) -> None:
    how = ", kept" if kept else f" after {result.wall_s:.1f} s"
    log.info("%s, seed %d: %s%s", result.task, result.seed, result.status, how)


@contextmanager
def counted(total: int, what: str) -> Iterator[Callable[[str], None]]:
    """Say on standard error how many of `total` are done: a bar on a terminal, else a line a minute at most.

    Args:
        total: how many there are.
        what: what they are called.

    Yields:
        A function that counts one, told its name.
    """
    if log.getEffectiveLevel() > logging.WARNING:
        yield lambda name: None
        return
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            line = bar.add_task("", total=total)
            yield lambda name: bar.update(line, advance=1, description=name)
        return
    done, spoken = 0, time.monotonic()

    def count(name: str) -> None:
        nonlocal done, spoken
        done += 1
        log.info("%s: %s", what, name)
        if time.monotonic() - spoken >= PAUSE_S or done == total:
            spoken = time.monotonic()
            print(f"tamp: {done} of {total} {what} done", file=sys.stderr, flush=True)

    yield count
