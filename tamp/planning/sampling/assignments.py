"""Calling an optimizer's procedure for several placeholders at once, of which facts shall hold."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tamp.clock import TimeUp
from tamp.errors import SamplerError
from tamp.planning.context import Certified, Context, generator_for
from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.sampling.optimizers import Component, ask
from tamp.planning.sampling.stream_calls import Sampling
from tamp.planning.wrappers import UnfitOutputsError, outputs_of, shown


class Assignments:
    """Asks procedures; each goes on where it left off when it is asked for the same again."""

    def __init__(self, knowledge: Knowledge, sampling: Sampling) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._running: dict[tuple[Fact, ...], Iterator[Any]] = {}

    def draw(self, external: External, outputs: list[int], facts: list[Fact]) -> tuple[int, ...] | None:
        """The next values for placeholders; None where there are no more, or none of the streams asks a procedure.

        Args:
            external: one of the streams whose placeholders they are.
            outputs: the placeholders.
            facts: what shall hold, constraints first by their predicates; functions of them shall be small.

        Raises:
            SamplerError: where there are not as many values as placeholders.
        """
        component = self._knowledge.schema.problem.samplers[external.name]
        if not isinstance(component, Component):
            return None
        names = {handle: f"?o{i}" for i, handle in enumerate(outputs)}
        written = tuple(self._written(fact, names) for fact in facts)
        counter = self._sampling.counted(external.name)
        self._sampling.draws += 1
        self._sampling.calls += 1
        try:
            with counter.calling():
                if (key := tuple(facts)) not in self._running:
                    context = self._context(external, len(self._running))
                    self._running[key] = iter(ask(component.procedure, context, tuple(names.values()), written))
                found = next(self._running[key], None)
        except UnfitOutputsError as error:
            raise self._sampling.misfit(external.name, error) from None
        except (Exception, TimeUp) as error:
            raise self._sampling.told(external.name, (), error) from (None if isinstance(error, TimeUp) else error)
        found = found.outputs if isinstance(found, Certified) else found
        if found is None:
            return None
        values = outputs_of(found, len(outputs))
        if values is None:
            raise SamplerError(
                f"optimizer {external.optimizer!r}: expected one value for each of {', '.join(names.values())}, "
                f"found {shown(found)}"
            )
        counter.successes += 1
        key_of_all = f"{external.optimizer}({len(self._running)})[{counter.calls}"
        intern = self._knowledge.objects.intern
        return tuple(intern(value, f"{key_of_all},{i}]") for i, value in enumerate(values))

    def _written(self, fact: Fact, names: dict[int, str]) -> tuple[Any, ...]:
        """A fact with names for its placeholders; a function of them as what shall be small."""
        values = self._knowledge.objects.values_of(fact)
        term = (values[0], *(names.get(h, v) for h, v in zip(fact[1:], values[1:], strict=True)))
        return ("minimize", term) if fact[0] in self._knowledge.schema.functions else term

    def _context(self, external: External, number: int) -> Context:
        seed, scene = self._sampling.seed, self._knowledge.schema.problem.scene
        name = external.optimizer
        return Context(scene, lambda: generator_for(seed, name, [str(number)]), self._sampling.deadline, seed=seed)
