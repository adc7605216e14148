"""Calling samplers: generators are kept, results cached, outputs checked, calls counted and timed."""

from __future__ import annotations

from typing import Any

import numpy as np

from tamp.errors import SamplerError, TampError
from tamp.planning.context import Context, generator_for
from tamp.planning.counting import Count
from tamp.planning.instances import Instance
from tamp.planning.knowledge import Knowledge
from tamp.planning.objects import Fact
from tamp.planning.outputs import Certified, answer_of, function_value, output_iterator, output_values
from tamp.planning.report import StreamReport


class Sampling:
    """Draws from streams and asks tests. Every result enters the knowledge at once; the search hears of it later."""

    def __init__(self, knowledge: Knowledge, seed: int, deadline: float) -> None:
        self._knowledge = knowledge
        self._problem = knowledge.schema.problem
        self._seed = seed
        self.deadline = deadline
        names = (*knowledge.schema.externals, *knowledge.schema.functions)
        self._counts = {name: Count() for name in names}
        self.function_values: dict[tuple[str, tuple[int, ...]], float] = {}
        self.draws = 0  # calls of streams with outputs
        self.wild = False  # whether any stream may certify more than it promises
        self.tame: set[str] = set()  # streams that are known not to

    def draw(self, instance: Instance, bound: tuple[Fact, ...] = ()) -> bool:
        """Ask a stream for its next output, or a test for its answer; whether there is a new result.

        Raises:
            SamplerError: where the output does not fit the stream.
        """
        if instance.exhausted:
            return False
        external = instance.external
        self.draws += bool(external.outputs)
        context = self._context(instance)
        context.bound = tuple(map(self._knowledge.objects.values_of, bound))
        counter = self._counts[external.name]
        instance.calls += 1
        with counter.calling():
            output = self._call(instance, context)
        if output is _END:
            instance.exhausted, output = True, None
        self._take_failures(instance, context, counter, failed=output is None)
        if output is None:
            return False
        counter.successes += 1
        return self._record(instance, output)

    def _context(self, instance: Instance) -> Context:
        if instance.context is None:
            objects = self._knowledge.objects

            def rng() -> np.random.Generator:
                keys = [objects.key(h) for h in instance.inputs]
                keys += [" ".join((f[0], *map(objects.key, f[1:]))) for f in instance.fluents]
                return generator_for(self._seed, instance.external.name, keys)

            facts = tuple(map(objects.values_of, instance.fluents))
            fluents = facts if instance.external.fluents else None
            instance.context = Context(self._problem.scene, rng, self.deadline, fluents)
        return instance.context

    def _call(self, instance: Instance, context: Context) -> Any:
        """One output, () for a test that holds, or None; marks the instance exhausted where nothing more can come."""
        external = instance.external
        values = [self._knowledge.objects.value(h) for h in instance.inputs]
        sampler = self._problem.samplers[external.name]
        try:
            if external.is_test:
                instance.exhausted = True
                return answer_of(external, sampler(context, *values))
            if instance.generator is None:
                instance.generator = output_iterator(external, sampler(context, *values))
            return next(instance.generator, _END)
        except (TampError, KeyboardInterrupt):
            raise
        except Exception as error:
            shown = ", ".join(self._knowledge.objects.name(h) for h in instance.inputs)
            raise RuntimeError(f"the sampler of stream {external.name!r} raised for ({shown}): {error!r}") from error

    def _take_failures(self, instance: Instance, context: Context, counter: Count, failed: bool) -> None:
        for reason, because in context.failures:
            counter.failures[reason] += 1
            if failed:
                facts = tuple(f for raw in because if (f := self._fluent(instance, raw)) is not None)
                instance.reasons[reason, facts] = instance.reasons.get((reason, facts), 0) + 1
        context.failures.clear()

    def _fluent(self, instance: Instance, raw: Any) -> Fact | None:
        """A fact that a sampler names as a cause, by handles."""
        fact = (str(raw[0]).lower(), *map(self._knowledge.objects.intern, raw[1:]))
        return fact if not instance.fluents or fact in instance.fluents else None

    def _record(self, instance: Instance, output: Any) -> bool:
        facts: tuple[tuple[Any, ...], ...] = ()
        if isinstance(output, Certified):
            output, facts = output.outputs, output.facts
            self.wild = True
        else:
            self.tame.add(instance.external.name)
        for raw in facts:
            self._knowledge.certify(self._extra(instance, raw), active=True)
        if output is None:
            return False
        handles = self._handles(instance, output)
        return self._knowledge.record(instance, handles)

    def _extra(self, instance: Instance, raw: tuple[Any, ...]) -> Fact:
        name = str(raw[0]).lower()
        if name in self._knowledge.schema.fluents:
            raise SamplerError(f"stream {instance.external.name!r} certifies {raw[0]!r}, which actions change")
        return (name, *map(self._knowledge.objects.intern, raw[1:]))

    def _handles(self, instance: Instance, output: Any) -> tuple[int, ...]:
        objects = self._knowledge.objects
        values = output_values(instance.external, output)
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
            context = Context(self._problem.scene, lambda: generator_for(self._seed, name, keys), self.deadline)
            try:
                with counter.calling():
                    value = self._problem.samplers[name](context, *map(objects.value, inputs))
            except Exception as error:
                raise RuntimeError(f"the sampler of function {name!r} raised: {error!r}") from error
            self.function_values[key] = function_value(name, value)
            counter.successes += 1
        return self.function_values[key]

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
