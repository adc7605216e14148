"""Calling a sampler as the planner does, and keeping everything that can be seen of it."""

from __future__ import annotations

import copy
import io
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tamp import clock
from tamp.conformance.form import short, shown
from tamp.conformance.sameness import same
from tamp.language import Stream
from tamp.planning import Problem
from tamp.planning.context import Context, generator_for
from tamp.planning.sampling import faults
from tamp.planning.sampling.stream_calls import output_iterator

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
        error: the exception that came out, or that time was up, in one line; empty where it went well.
        trace: the exception's traceback; empty where none came out.
        left_behind: what it did besides giving outputs: inputs changed, threads left running, prints.
        fluents: the facts that it was told, where its stream has `:fluents`.
    """

    inputs: tuple[Any, ...]
    raw: tuple[Any, ...]
    outputs: tuple[tuple[Any, ...], ...]
    seconds: tuple[float, ...]
    ended: bool
    reasons: tuple[str, ...]
    error: str = ""
    trace: str = ""
    left_behind: tuple[str, ...] = ()
    fluents: tuple[Any, ...] = ()

    @property
    def failure(self) -> str:
        """What ended it before its time, with its inputs; empty where nothing did."""
        told = (
            f"raised for {shown(self.inputs)}: {self.error}" if self.trace else f"{self.error} for {shown(self.inputs)}"
        )
        return told if self.error else ""

    def __str__(self) -> str:
        end = "" if self.ended else ", and there is more"
        reasons = f"; it said: {', '.join(dict.fromkeys(self.reasons))}" if self.reasons else ""
        given = f"{len(self.raw)} outputs in {sum(self.seconds):.3g} s{end}{reasons}"
        first = f"; the first: {short(self.raw[0])}" if self.raw else ""
        return f"{shown(self.inputs)}: {given}{first}"


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
    fluents = fluents_of(problem, stream, values)
    context = Context(
        problem.scene,
        lambda: generator_for(seed, stream.name, [key]),
        clock.now() + PATIENCE_S,
        fluents if stream.fluents else None,
        seed,
    )
    function = problem.samplers[stream.name] if sampler is None else sampler
    raw: list[Any] = []
    seconds: list[float] = []
    ended, error, trace = False, "", ""
    before, threads, printed = copy.deepcopy(values), threading.active_count(), io.StringIO()
    try:
        with clock.ended_at(clock.now() + PATIENCE_S), redirect_stdout(printed):
            for ended, value in _draws(stream, function, context, values, outputs, seconds):
                if not ended:
                    raw.append(value)
    except clock.TimeUp:
        error = f"nothing came for {PATIENCE_S:g} s"
    except BaseException as problem_of_theirs:  # whatever comes out is what the kit was asked to tell
        if faults.interrupts(function, problem_of_theirs):
            raise
        error, trace = _told(problem_of_theirs, function), traceback.format_exc()
    formed = tuple(f for value in raw if (f := _formed(stream, value)) is not None)
    reasons = tuple(reason for reason, *_ in context.failures)
    left = _left_behind(values, before, threads, printed.getvalue())
    return Call(values, tuple(raw), formed, tuple(seconds), ended, reasons, error, trace, left, fluents)


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
    iterator = output_iterator(stream, made)
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


def fluents_of(problem: Problem, stream: Stream, values: tuple[Any, ...]) -> tuple[Any, ...]:
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


def _left_behind(inputs: tuple[Any, ...], before: tuple[Any, ...], threads: int, said: str) -> tuple[str, ...]:
    """What a call has done besides giving outputs."""
    changed = [(was, now) for was, now in zip(before, inputs, strict=True) if not same(was, now)]
    found = [f"changed its input {short(was)} to {short(now)}" for was, now in changed]
    if threading.active_count() > threads:
        found.append(f"left {threading.active_count() - threads} thread(s) running")
    if said:
        found.append(f"printed {short(said)}")
    return tuple(found)


def _told(error: BaseException, function: Callable[..., Any]) -> str:
    """An exception in one line, with the line of the sampler's own file, and the innermost one if it is another's."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    frames = traceback.extract_tb(error.__traceback__)
    own = faults.line_of(function, error.__traceback__) or f"{frames[-1].filename}:{frames[-1].lineno}"
    innermost = f"{frames[-1].filename}:{frames[-1].lineno}"
    places = [own] if own == innermost else [own, innermost]
    return f"{text} ({', in '.join('/'.join(Path(place).parts[-2:]) for place in places)})"
