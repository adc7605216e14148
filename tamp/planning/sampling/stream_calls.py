"""Calling streams: a sampler's outputs one at a time, checked, counted and timed."""

from __future__ import annotations

import numbers
import reprlib
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, TypeVar

import numpy as np

from tamp import clock
from tamp.clock import TimeUp
from tamp.errors import SamplerError
from tamp.language import Stream
from tamp.planning.context import Certified, Context, generator_for
from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import Instance
from tamp.planning.report import StreamReport
from tamp.planning.sampling import faults
from tamp.planning.wrappers import Adapted, UnfitOutputsError, outputs_of, shown

T = TypeVar("T")

TEST_DRAWS = 100
"""How often a test that is given as a generator is asked for an output before it counts as one that does not hold."""


def answer_of(external: External, answer: Any) -> Any:
    """What a test answered: () where it holds, None where not, or what it certifies besides.

    Raises:
        SamplerError: where it is neither.
    """
    if isinstance(answer, Certified):
        return answer if answer.outputs is not None else Certified(None, answer.facts)
    if not isinstance(answer, bool | np.bool_):
        raise SamplerError(f"test {external.name!r}: expected True or False, found {reprlib.repr(answer)}")
    return () if answer else None


def first_of(answers: Iterator[Any]) -> Any:
    """The answer of a test that is given as a stream is: it holds where there is an output."""
    found = next((output for output in islice(answers, TEST_DRAWS) if output is not None), None)
    return found if isinstance(found, Certified) else found is not None


def output_iterator(external: External | Stream, made: Any) -> Iterator[Any]:
    """The outputs of a call, one at a time.

    Raises:
        SamplerError: where it returned nothing that can be iterated over.
    """
    if not isinstance(made, Iterable):
        raise SamplerError(
            f"stream {external.name!r}: expected a generator function that yields one output at a time, "
            f"but the function returned {reprlib.repr(made)}"
        )
    return iter(made)


def output_values(external: External, output: Any) -> tuple[Any, ...]:
    """The values of one output, one for each output of the stream.

    Raises:
        SamplerError: where their number differs.
    """
    count = len(external.outputs)
    if count == 0:
        return ()
    values = outputs_of(output, count)
    if values is None:
        names = ", ".join(name[1:] for name in external.outputs)
        raise SamplerError(
            f"stream {external.name!r}: expected to yield a tuple of {count} output{'s' * (count > 1)} ({names}), "
            f"found {shown(output)}"
        )
    return values


def function_value(name: str, value: Any) -> float:
    """The value of a function.

    Raises:
        SamplerError: where it is no finite number of 0 or more.
    """
    if not isinstance(value, numbers.Real) or not 0 <= float(value) < float("inf"):
        raise SamplerError(f"function {name!r}: expected a finite number of 0 or more, found {reprlib.repr(value)}")
    return float(value)


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

    @property
    def odds(self) -> float:
        """The share of calls that gave something; 1 as long as none did, of which nothing can be told."""
        return self.successes / self.calls if self.successes else 1.0

    def report(self, name: str) -> StreamReport:
        """The counts for the report, the most frequent reason first."""
        reasons = tuple(sorted(self.failures.items(), key=lambda item: (-item[1], item[0])))
        return StreamReport(name, self.calls, self.successes, self.seconds, reasons)


class Sampling:
    """Draws from streams and asks tests. Every result enters the knowledge at once; the search hears of it later."""

    def __init__(self, knowledge: Knowledge, seed: int, deadline: float) -> None:
        self._knowledge = knowledge
        self._problem = knowledge.schema.problem
        self.seed = seed
        self.deadline = deadline
        names = [external.sampler for external in knowledge.schema.externals.values()]
        self._counts = {name: Count() for name in (*names, *knowledge.schema.functions)}
        self.function_values: dict[tuple[str, tuple[int, ...]], float] = {}
        self.draws = 0  # calls of streams with outputs
        self.calls = 0  # calls of streams and tests
        self.wild: set[str] = set()  # the streams that certify more than they promise
        self.tame: set[str] = set()  # streams that are known not to
        self.news = 0  # facts beyond what streams promise

    def draw(self, instance: Instance, bound: tuple[Fact, ...] = (), *, brief: bool = False) -> bool:
        """Ask a stream for its next output, or a test for its answer; whether there is a new result.

        `brief`: nobody waits for it, so that a sampler that works long may pause.

        Raises:
            SamplerError: where the output does not fit the stream.
        """
        if instance.exhausted:
            return False
        external = instance.external
        self.draws += bool(external.outputs)
        self.calls += 1
        context = self._context(instance)
        context.bound = tuple(map(self._knowledge.objects.values_of, bound))
        context.brief, context.paused = brief, False
        counter = self._counts[external.sampler]
        instance.calls += 1
        with counter.calling():
            output = self._call(instance, context)
        if context.paused and output is None:
            counter.calls -= 1  # it is the same call that goes on the next time
            return False
        if output is _END:
            if external.outputs and clock.now() > self.deadline:  # it may have ended for that: next time, from anew
                instance.generator = None
            else:
                instance.exhausted = True
                instance.gave_up |= not external.info.complete
            output = None
        if output is not None or not (instance.exhausted and instance.results):  # the end of all that there is
            instance.record.calls += 1
            instance.record.successes += output is not None
        self._take_failures(instance, context, counter, failed=output is None)
        if output is None:
            return False
        counter.successes += 1
        return self._record(instance, output)

    def continue_until(self, deadline: float) -> None:
        """Let every sampler know of another deadline, those under way as well, and count calls from here on."""
        self.deadline = deadline
        self._counts = {name: Count() for name in self._counts}
        for instance in self._knowledge.instances():
            if instance.context is not None:
                instance.context.deadline = deadline

    def _context(self, instance: Instance) -> Context:
        if instance.context is None:
            objects = self._knowledge.objects

            def rng() -> np.random.Generator:
                keys = [objects.key(h) for h in instance.inputs]
                keys += [" ".join((f[0], *map(objects.key, f[1:]))) for f in instance.fluents]
                return generator_for(self.seed, instance.external.sampler, keys)

            facts = tuple(map(objects.values_of, instance.fluents))
            fluents = facts if instance.external.fluents else None
            instance.context = Context(self._problem.scene, rng, self.deadline, fluents, self.seed)
        return instance.context

    def _call(self, instance: Instance, context: Context) -> Any:
        """One output, () for a test that holds, or None; marks the instance exhausted where nothing more can come."""
        external = instance.external
        sampler = self._problem.samplers[external.sampler]
        values = [self._knowledge.objects.value(h) for h in instance.inputs]
        if external.is_test:
            instance.exhausted = True
            answer = self._run(instance, sampler, context, *values)
            if external.asks is not None:
                answer = self._fitting(instance, output_iterator, answer)
            if isinstance(sampler, Adapted) and isinstance(answer, bool):  # it can certify no more than that
                self.tame.add(external.name)
            if isinstance(answer, Iterator):
                answer = self._run(instance, first_of, answer)
            return self._fitting(instance, answer_of, answer)
        if instance.generator is None:
            made = self._run(instance, sampler, context, *values)
            instance.generator = self._fitting(instance, output_iterator, made)
        return self._run(instance, next, instance.generator, _END)

    def _run(self, instance: Instance, function: Callable[..., Any], *arguments: Any) -> Any:
        """Run a sampler's own code; whatever it raises is the sampler's error."""
        name = instance.external.sampler
        try:
            return function(*arguments)
        except UnfitOutputsError as error:
            raise self.misfit(name, error) from None
        except SamplerError:
            raise
        except BaseException as error:
            if faults.interrupts(self._problem.samplers[name], error):
                raise
            raise self.told(name, instance.inputs, error) from (None if isinstance(error, TimeUp) else error)

    def misfit(self, name: str, error: UnfitOutputsError) -> SamplerError:
        """That what a wrapped function gave for a stream does not fit its wrapper, in a sentence that names it."""
        return faults.unfit(SamplerError(f"stream {name!r}: {error}"), self._problem.samplers[name])

    def told(self, name: str, inputs: tuple[int, ...], error: BaseException) -> BaseException:
        """What a sampler raised, or that it was interrupted, in a sentence that names it."""
        sampler, shown = self._problem.samplers[name], ", ".join(map(self._shown, inputs))
        if not isinstance(error, TimeUp):
            return faults.raised(name, sampler, shown, error)
        return error if repr(name) in str(error) else TimeUp(faults.late(name, sampler, shown, error))

    def _shown(self, handle: int) -> str:
        """An input of a sampler, and the stream that it comes from: that one may be to blame."""
        source = self._knowledge.source(handle)
        return self._knowledge.objects.name(handle) + (f" from {source.external.name}" if source else "")

    def _fitting(self, instance: Instance, read: Callable[[External, Any], T], given: Any) -> T:
        """What a sampler gave, read as its stream has it."""
        try:
            return read(instance.external, given)
        except UnfitOutputsError as error:
            raise self.misfit(instance.external.sampler, error) from None
        except SamplerError as error:
            sampler = self._problem.samplers[instance.external.sampler]
            raise faults.unfit(error, sampler, instance.generator) from None

    def _take_failures(self, instance: Instance, context: Context, counter: Count, failed: bool) -> None:
        instance.gave_up |= context.gave_up
        for reason, because in context.failures:
            counter.failures[reason] += 1
            if failed:
                facts = tuple(f for raw in because if (f := self._fluent(instance, raw)) is not None)
                instance.reasons[reason, facts] = instance.reasons.get((reason, facts), 0) + 1
        context.failures.clear()

    def _fluent(self, instance: Instance, raw: Any) -> Fact | None:
        """A fact that a sampler names as a cause, by handles."""
        fact = (str(raw[0]).lower(), *map(self._knowledge.objects.intern, raw[1:]))
        fact = self._knowledge.schema.inner(fact)
        return fact if not instance.fluents or fact in instance.fluents else None

    def _record(self, instance: Instance, output: Any) -> bool:
        facts: tuple[tuple[Any, ...], ...] = ()
        if isinstance(output, Certified):
            output, facts = output.outputs, output.facts
            self.wild.add(instance.external.name)
        else:
            self.tame.add(instance.external.name)
        for raw in facts:
            before = self._knowledge.version
            self._knowledge.certify(self._extra(raw, instance), active=True)
            self.news += self._knowledge.version > before
        if output is None:
            return False
        handles = self._handles(instance, output)
        return self._knowledge.record(instance, handles)

    def _extra(self, raw: tuple[Any, ...], instance: Instance) -> Fact:
        """A fact beyond what a stream promises, by handles."""
        objects = self._knowledge.objects
        known = len(objects)
        fact = (str(raw[0]).lower(), *map(objects.intern, raw[1:]))
        self._knowledge.bringers |= dict.fromkeys(range(known, len(objects)), instance)
        return self._knowledge.schema.inner(fact)

    def _handles(self, instance: Instance, output: Any) -> tuple[int, ...]:
        objects = self._knowledge.objects
        values = self._fitting(instance, output_values, output)
        key = f"{instance.external.name}({','.join(map(objects.key, instance.inputs))})[{len(instance.results)}"
        return tuple(objects.intern(value, f"{key},{i}]") for i, value in enumerate(values))

    def function(self, name: str, inputs: tuple[int, ...]) -> float:
        """What a function stream returns for real inputs.

        Raises:
            SamplerError: where it is no number of 0 or more.
        """
        key = (name, inputs)
        if key not in self.function_values:
            objects, counter = self._knowledge.objects, self._counts[name]
            keys = [objects.key(handle) for handle in inputs]
            context = Context(
                self._problem.scene, lambda: generator_for(self.seed, name, keys), self.deadline, seed=self.seed
            )
            try:
                with counter.calling():
                    value = self._problem.samplers[name](context, *map(objects.value, inputs))
            except (Exception, TimeUp) as error:
                raise self.told(name, inputs, error) from (None if isinstance(error, TimeUp) else error)
            try:
                self.function_values[key] = function_value(name, value)
            except SamplerError as error:
                raise faults.unfit(error, self._problem.samplers[name]) from None
            counter.successes += 1
        return self.function_values[key]

    def counted(self, name: str) -> Count:
        """The calls of a stream."""
        return self._counts[name]

    def report(self) -> tuple[StreamReport, ...]:
        """The counts of each stream, in the order of the file."""
        return tuple(count.report(name) for name, count in self._counts.items())

    @property
    def seconds(self) -> float:
        """Time spent inside samplers [s]."""
        return sum(c.seconds for c in self._counts.values())


class _End:
    """What a generator that has ended gives."""


_END = _End()


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
