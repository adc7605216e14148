"""Calling a sampler as the planner does, and keeping everything that can be seen of it."""

from __future__ import annotations

import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tamp.language import Stream
from tamp.planning import Problem
from tamp.planning.context import Context, generator_for

PATIENCE_S = 60.0
"""A call that gives nothing back for so long is broken off [s]."""


@dataclass(frozen=True)
class Call:
    """One call of a sampler.

    Attributes:
        inputs: what it was called with, without the context.
        raw: what it yielded, as it came; for a test the single answer.
        outputs: tuples of outputs, where what came has the right form; () for a test that holds.
        seconds: how long each draw took, the last, empty one included [s].
        ended: whether it came to its end.
        reasons: what it told `context.fail`.
        error: the exception that came out, in one line; empty where none did.
    """

    inputs: tuple[Any, ...]
    raw: tuple[Any, ...]
    outputs: tuple[tuple[Any, ...], ...]
    seconds: tuple[float, ...]
    ended: bool
    reasons: tuple[str, ...]
    error: str = ""


def call(
    problem: Problem,
    stream: Stream,
    values: tuple[Any, ...],
    *,
    key: str,
    seed: int,
    outputs: int,
    sampler: Callable[..., Any] | None = None,
) -> Call:
    """Call a stream's sampler and draw from it.

    Args:
        problem: gives the scene and, where `sampler` is None, the sampler.
        stream: the stream.
        values: its inputs.
        key: names the inputs for the random generator.
        seed: of the random generator.
        outputs: draw at most so many.
        sampler: called instead of the problem's own.
    """
    context = Context(
        problem.scene,
        lambda: generator_for(seed, stream.name, [key]),
        time.monotonic() + PATIENCE_S,
        _fluents(problem, stream, values) if stream.fluents else None,
    )
    function = problem.samplers[stream.name] if sampler is None else sampler
    raw: list[Any] = []
    seconds: list[float] = []
    ended, error = False, ""
    try:
        with _broken_off_after(PATIENCE_S):
            for ended, value in _draws(stream, function, context, values, outputs, seconds):
                if not ended:
                    raw.append(value)
    except Exception as problem_of_theirs:  # whatever comes out is what the kit was asked to tell
        error = _told(problem_of_theirs)
    formed = tuple(f for value in raw if (f := _formed(stream, value)) is not None)
    return Call(values, tuple(raw), formed, tuple(seconds), ended, tuple(r for r, _ in context.failures), error)


def _draws(
    stream: Stream,
    function: Callable[..., Any],
    context: Context,
    values: tuple[Any, ...],
    outputs: int,
    seconds: list[float],
) -> Iterator[tuple[bool, Any]]:
    """(False, value) for each draw, and (True, None) at the end; draws of None, "nothing yet", are left out."""
    began = time.perf_counter()
    made = function(context, *values)
    if stream.is_test:
        seconds.append(time.perf_counter() - began)
        yield False, made
        yield True, None
        return
    iterator = iter(made)
    for _ in range(outputs):
        try:
            value = next(iterator)
        except StopIteration:
            seconds.append(time.perf_counter() - began)
            yield True, None
            return
        seconds.append(time.perf_counter() - began)
        if value is not None:
            yield False, value
        began = time.perf_counter()


def _fluents(problem: Problem, stream: Stream, values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Facts of the initial state that a stream with `:fluents` sees; what is handed in is in the hand, not standing."""
    wanted = {name.lower() for name in stream.fluents}
    objects = {value for value in values if isinstance(value, str)}
    facts = (fact for fact in problem.init if str(fact[0]).lower() in wanted)
    return tuple((str(f[0]).lower(), *f[1:]) for f in facts if not objects & {a for a in f[1:] if isinstance(a, str)})


def _formed(stream: Stream, value: Any) -> tuple[Any, ...] | None:
    """The outputs in one draw; None where it has not the stream's form."""
    value = getattr(value, "outputs", value)  # planning.Certified carries facts beside the outputs
    if stream.is_test:
        return () if value else None
    if len(stream.outputs) == 1:
        return (value,)
    return tuple(value) if isinstance(value, tuple | list) and len(value) == len(stream.outputs) else None


@contextmanager
def _broken_off_after(limit: float) -> Iterator[None]:
    """Raise TimeoutError inside after `limit` seconds; only a main thread can be told so."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(*_: object) -> None:
        raise TimeoutError(f"nothing came for {limit:g} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _told(error: Exception) -> str:
    frame = traceback.extract_tb(error.__traceback__)[-1]
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return f"{text} ({Path(frame.filename).name}:{frame.lineno})"
