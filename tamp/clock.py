"""The clock that time limits are kept on: wall time, or the processor time of this process and its children.

A limit in wall time is what a person waits for; the same limit in processor time gives a search the same work on a busy
machine as on an idle one. Every deadline in the planner, the samplers and the pipeline is a value of `now()`.
"""

from __future__ import annotations

import contextlib
import inspect
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from types import FrameType
from typing import Literal

Clock = Literal["wall", "processor"]

GRACE_S = 0.4
"""What goes on for longer than this past its deadline does not look at the clock, and is interrupted [s]."""
AGAIN_S = 0.1
"""How soon what catches the interruption is interrupted again [s]."""
FOREVER_S = 1e6
"""A longer limit is none: nobody waits for its end, and timers count no further [s]."""

_CLOCK: ContextVar[Clock] = ContextVar("tamp-clock", default="wall")
_SHIFT: ContextVar[float] = ContextVar("tamp-shift", default=0.0)
_WATCH: ContextVar[Callable[[float | None], None] | None] = ContextVar("tamp-watch", default=None)


def now() -> float:
    """The time on the clock that limits are kept on [s]; only differences mean anything."""
    return time.monotonic() if _CLOCK.get() == "wall" else sum(os.times()[:4]) + _SHIFT.get()


def carry_on(at: float) -> None:
    """Let the clock show `at` [s], as where another process comes in place of one, or has computed for it in vain.

    What passes is the same for all processes: on wall time this does nothing.
    """
    if _CLOCK.get() == "processor":
        _SHIFT.set(_SHIFT.get() + at - now())


def in_use() -> Clock:
    """The name of that clock."""
    return _CLOCK.get()


@contextmanager
def limits_in(clock: Clock) -> Iterator[None]:
    """Keep time limits on a clock while the block runs, in this thread."""
    token = _CLOCK.set(clock)
    try:
        yield
    finally:
        _CLOCK.reset(token)


class TimeUp(BaseException):
    """Raised in the middle of what goes on past its deadline; no `except Exception` of a sampler's stops it."""


@contextmanager
def ended_at(deadline: float, gives_way: bool = False) -> Iterator[None]:
    """End the block by TimeUp where it goes on past a deadline, whatever it does: it may sleep, or spin.

    Python can be interrupted in the main thread alone, and between two of its own instructions: native code that does
    not return, and calls from other threads, are not. Whoever watches this process from outside (`watched`) is told
    the deadline and can end it.

    Args:
        deadline: on the clock of `now` [s].
        gives_way: whether what is asked inside for the same, for an earlier deadline, counts: otherwise it does not.
    """
    watch = _WATCH.get() if in_use() == "wall" else None
    if watch is not None:
        watch(deadline)
    try:
        with _alarm(deadline, gives_way):
            yield
    finally:
        if watch is not None:
            watch(None)


@contextmanager
def watched(watch: Callable[[float | None], None]) -> Iterator[None]:
    """Tell `watch` each deadline of `ended_at` as it comes, in time.monotonic() [s], and None as it is no more."""
    token = _WATCH.set(watch)
    try:
        yield
    finally:
        _WATCH.reset(token)


def tell(until: float | None) -> None:
    """Tell whoever watches a deadline as `ended_at` does, on behalf of another process."""
    if (watch := _WATCH.get()) is not None:
        watch(until)


def rearm() -> None:
    """Set the alarm of `ended_at` again in a forked process: alarms are not inherited."""
    if _is_ours(signal.getsignal(signal.SIGALRM)):
        signal.setitimer(signal.ITIMER_REAL, AGAIN_S)


def disarm() -> None:
    """Have the alarm of `ended_at` never ring, in a process that only waits for another."""
    if _is_ours(signal.getsignal(signal.SIGALRM)):
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _is_ours(handler: object) -> bool:
    return getattr(handler, "__module__", None) == __name__


def is_free() -> bool:
    """Whether `ended_at` would end a block here: there is no other around it that does not give way."""
    handler = signal.getsignal(signal.SIGALRM)
    return handler is signal.SIG_DFL or (isinstance(handler, _Alarm) and handler.gives_way)


CALLED_BACK = frozenset(
    {
        ("numba.core.serialize", "_numba_unpickle"),  # a value to be returned: SystemError
        ("llvmlite.binding.executionengine", "_raw_object_cache_notify"),  # what was compiled: it is lost for good
        ("llvmlite.binding.executionengine", "_raw_object_cache_getbuffer"),
    }
)
"""Functions, by module and name, that C calls and that it hears no exception of."""


@dataclass(eq=False)
class _Alarm:
    """Raises TimeUp past a deadline, where `asker` is among what is running; rings for nobody once it is empty."""

    deadline: float
    gives_way: bool
    asker: FrameType | None
    outer: _Alarm | None = None

    def __call__(self, _: int, frame: FrameType | None) -> None:
        left = self.deadline + GRACE_S - now()
        if self.asker is None or all(calling is not self.asker for calling in _stack(frame)):
            self.disarm()  # whoever asked is gone without a word
            return
        signal.setitimer(signal.ITIMER_REAL, min(FOREVER_S, left) if left > 0 else AGAIN_S)
        if left <= 0 and not _on_the_threshold(frame) and not _called_by_compiled(frame):
            raise TimeUp(f"interrupted {GRACE_S:g} s past the limit")

    def arm(self) -> None:
        left = self.deadline + GRACE_S - now()
        signal.setitimer(signal.ITIMER_REAL, min(FOREVER_S, max(AGAIN_S, left)))

    def disarm(self) -> None:
        ringing: object = signal.getsignal(signal.SIGALRM)
        if ringing is self:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, self.outer or signal.SIG_DFL)
            if self.outer is not None:
                self.outer.arm()


@contextmanager
def _alarm(deadline: float, gives_way: bool) -> Iterator[None]:
    """Raise TimeUp by the process's alarm clock, where that is free."""
    main = threading.current_thread() is threading.main_thread()
    if not main or math.isinf(deadline) or not is_free():
        yield
        return
    handler = signal.getsignal(signal.SIGALRM)
    outer = handler if isinstance(handler, _Alarm) else None
    alarm = _Alarm(deadline if outer is None else min(deadline, outer.deadline), gives_way, _asker(), outer)
    signal.signal(signal.SIGALRM, alarm)
    try:
        alarm.arm()
        yield
    finally:
        alarm.asker = None  # first of all: an alarm that rings from here on must find nobody
        alarm.disarm()


def _stack(frame: FrameType | None) -> Iterator[FrameType]:
    """A frame and all that called it, innermost first."""
    while frame is not None:
        yield frame
        frame = frame.f_back


def _asker() -> FrameType | None:
    """The function whose `with` statement is being entered, through context managers that are generators."""
    passed = {contextlib.__file__, __file__}
    for frame in _stack(sys._getframe(1)):
        if frame.f_code.co_filename not in passed and not frame.f_code.co_flags & inspect.CO_GENERATOR:
            return frame
    return None


_MANAGER = contextlib._GeneratorContextManager


def _on_the_threshold(frame: FrameType | None) -> bool:
    """Whether a context manager is being entered or left: interrupted there, it would never be told to clean up."""
    if frame is None:
        return False
    own = frame.f_code.co_filename == __file__ and frame.f_code is not now.__code__
    return own or frame.f_code in (_MANAGER.__enter__.__code__, _MANAGER.__exit__.__code__)


def _called_by_compiled(frame: FrameType | None) -> bool:
    """Whether compiled code has called Python for what it needs, and goes on without where that is interrupted."""
    return any((calling.f_globals.get("__name__"), calling.f_code.co_name) in CALLED_BACK for calling in _stack(frame))
