"""Speculative execution: to go on from the likely outcome of a slow test while it is still tested, on another core.

The process that comes to such a test forks. The new one goes on at once as if the outcome were the likely one; the old
one tests. Where it was right, the old process has only to pass on what the new one comes to; where not, it ends the new
one and goes on itself with what it found. So the outcome is that of one process alone, and comes sooner. (Burton 1985,
Speculative computation, parallelism, and functional programming.)
"""

from __future__ import annotations

import mmap
import os
import pickle
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from contextvars import ContextVar
from dataclasses import dataclass, replace
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, NoReturn, TypeVar

from tamp import clock
from tamp.errors import TampError
from tamp.parent import end_with_parent

T = TypeVar("T")

LONGEST = 1024  # processes one after the other, of which all but the last few only wait


@dataclass(frozen=True)
class _Link:
    """A process in a chain of which each goes on from what the one before presumes.

    Attributes:
        outlet: where its outcome goes: to the process before, or to who asked.
        working: shared by all, a byte for each: whether it computes.
        place: its own in the chain.
        threads: how many may compute at the same time.
    """

    outlet: Connection
    working: mmap.mmap
    place: int
    threads: int

    @property
    def has_room(self) -> bool:
        """Whether one more may compute."""
        return self.place + 1 < LONGEST and sum(self.working[: self.place + 1]) < self.threads


_LINK: ContextVar[_Link | None] = ContextVar("tamp-speculation", default=None)


def speculating(work: Callable[[], T], threads: int) -> T:
    """What `work` returns or raises, where `presumed` inside it goes on before its tests are done.

    With more threads than one it runs in other processes, so that what it returns or raises is pickled, and what it
    changes in memory is lost. Their random choices are those of one thread. On the clock of processor time counts what
    leads to the outcome; what was computed beside it, or in vain, does not.

    Args:
        work: a function of no arguments.
        threads: how many processes may compute at the same time; with one, `work` is called here.

    Raises:
        TampError: where a process ends without an outcome, or the system cannot do this.
    """
    if threads == 1 or _LINK.get() is not None:
        return work()
    if not sys.platform.startswith("linux"):
        raise TampError(f"threads is {threads}; on this system valid is 1, others need Linux")
    link = _Link(*_nobody(), place=-1, threads=threads)
    child, inlet = _fork(link)
    if child == 0:
        _end(work)
    try:
        kind, what, at = _last_message(inlet)
    except EOFError:
        code = _reap(child)
        how = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
        raise TampError(f"the process that did the work ended {how} and left no outcome") from None
    except BaseException:
        _reap(child)
        raise
    _reap(child)
    clock.carry_on(at)
    if kind == "raised":
        error, where = what
        raise error from RuntimeError(f"in another process\n\n{where}")
    returned: T = what
    return returned


def presumed(test: Callable[[], T], likely: T) -> T:
    """What `test` returns; inside `speculating` another process has gone on from `likely` by then.

    Args:
        test: a function of no arguments; what it changes in memory is seen only where it returns something else.
        likely: what it returns as a rule.
    """
    link = _LINK.get()
    if link is None or not link.has_room:
        return test()
    child, inlet = _fork(link)
    if child == 0:
        return likely
    try:
        found = test()
    except BaseException:
        _reap(child)
        raise
    if found == likely:
        _pass_on(child, inlet, link)
    _reap(child)
    return found


def _nobody() -> tuple[Connection, mmap.mmap]:
    """The outlet and the shared bytes of a chain without processes."""
    return Pipe(duplex=False)[1], mmap.mmap(-1, LONGEST)


def _fork(link: _Link) -> tuple[int, Connection]:
    """Begin the next process of the chain: its number, 0 inside it, and where its outcome comes from."""
    inlet, outlet = Pipe(duplex=False)
    at, parent = clock.now(), os.getpid()
    ahead = replace(link, outlet=outlet, place=link.place + 1)
    ahead.working[ahead.place] = 1
    _flush()  # what waits there would be written twice
    child = os.fork()
    if child != 0:
        outlet.close()
        return child, inlet
    end_with_parent()
    if os.getppid() != parent:  # it ended before that
        os._exit(1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who asked is interrupted, and ends all
    inlet.close()
    link.outlet.close()
    clock.carry_on(at)
    clock.rearm()
    _LINK.set(ahead)
    return child, inlet


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        stream.flush()


def _end(work: Callable[[], Any]) -> NoReturn:
    """Do the work, send what comes of it, and end: by then this may be another process than began it."""

    def send(*message: Any) -> None:
        link = _LINK.get()
        assert link is not None
        link.outlet.send(message)

    try:
        try:
            with clock.watched(lambda until: send("until", until, 0.0)):
                outcome = ("returned", work())
        except BaseException as error:
            outcome = ("raised", (error, traceback.format_exc()))
        _flush()  # whoever reads the outcome ends this process
        try:
            send(*outcome, clock.now())
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            refusal = TampError(f"with more threads than one, outcomes are pickled: {error}")
            send("raised", (refusal, traceback.format_exc()), clock.now())
    finally:
        os._exit(0)


def _last_message(inlet: Connection) -> tuple[str, Any, float]:
    """How the first process of a chain ends, with what, and when; whoever watches is told of deadlines meanwhile.

    Raises:
        EOFError: where it ends without a word.
    """
    while True:
        kind, what, at = inlet.recv()
        if kind != "until":
            return kind, what, at
        clock.tell(what)


def _pass_on(child: int, inlet: Connection, link: _Link) -> NoReturn:
    """Send on what the next process comes to, and end as it does."""
    clock.disarm()
    link.working[link.place] = 0
    try:
        while True:
            link.outlet.send_bytes(inlet.recv_bytes())
    except EOFError:
        code = _reap(child)
        if code < 0:
            with suppress(OSError):  # some signals cannot be handled otherwise
                signal.signal(-code, signal.SIG_DFL)
            os.kill(os.getpid(), -code)
        os._exit(code)
    finally:
        os._exit(1)


def _reap(child: int) -> int:
    """End the next process, and with it all that come after, without counting what they computed; its exit code."""
    at = clock.now()
    os.kill(child, signal.SIGKILL)  # it is there until it is waited for, even where it has ended
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    clock.carry_on(at)
    return code
