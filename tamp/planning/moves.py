"""Making the moves that were left out of the search: a connector from where its fluent is to where it is wanted."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from tamp.planning.attempt import BoundStep, FailedMove
from tamp.planning.connectors import Connector, Connectors
from tamp.planning.evaluate import Evaluator
from tamp.planning.instances import Instance, ground
from tamp.planning.knowledge import Knowledge
from tamp.planning.objects import Fact
from tamp.planning.sampling import Sampling
from tamp.planning.state import State


@dataclass
class Stuck:
    """Why no move was possible.

    Attributes:
        facts: facts of the state to blame; empty where nothing is known.
        failed: the moves whose streams had nothing to give.
    """

    facts: dict[Fact, None] = field(default_factory=dict)
    failed: list[FailedMove] = field(default_factory=list)
    reason: str = "no action leads from one to the other"


class Mover:
    """Finds moves; what their streams gave for a state is kept with the instance."""

    def __init__(
        self,
        knowledge: Knowledge,
        sampling: Sampling,
        evaluator: Evaluator,
        connectors: Connectors,
        deadline: float,
    ) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._evaluator = evaluator
        self._connectors = connectors
        self._deadline = deadline

    def move(self, target: Fact, state: State, patience: int) -> BoundStep | Stuck:
        """A move to `target`, the fact that the connectors' fluent shall have.

        A stream is asked until it misses `patience` times in a row.
        """
        stuck = Stuck()
        given = self._evaluator.given
        for connector in self._connectors.connectors:
            terms = zip(connector.after[1:], target[1:], strict=True)
            start: dict[str, int] = {t: h for t, h in terms if isinstance(t, str)}
            for found, support in list(self._evaluator.satisfy(connector.fluents, start, state)):
                complete = self._sampled(connector, found, state, patience, stuck)
                if complete is None:
                    stuck.facts.update(dict.fromkeys(support))
                elif all(given(ground(p, complete)) for p in connector.static):
                    return BoundStep(connector.schema, complete)
        return stuck

    def _sampled(
        self, connector: Connector, binding: dict[str, int], state: State, patience: int, stuck: Stuck
    ) -> dict[str, int] | None:
        """The binding with the outputs of the connector's streams; None where one of them has nothing to give."""
        for external, pattern in connector.streams:
            certified = next(c for c in external.certified if c[0] == pattern[0])
            terms = dict(zip(certified[1:], pattern[1:], strict=True))
            inputs = tuple(binding[str(terms[v])] for v in external.inputs)
            fluents = tuple(f for f in state if f[0] in external.fluents)
            instance = self._knowledge.instance(external, inputs, fluents)
            if all(map(self._evaluator.given, instance.domain)):
                self._draw(instance, state, patience)
            if not instance.results:
                reason, facts = instance.main_reason
                stuck.reason = f"{external.name}: {reason}"
                stuck.facts.update(dict.fromkeys(facts or fluents))
                source, target = (binding[str(p[connector.position])] for p in (connector.before, connector.after))
                stuck.failed.append(FailedMove(source, target, facts))
                return None
            outputs = dict(zip(external.outputs, instance.results[0], strict=True))
            for variable, term in terms.items():
                if variable in outputs and isinstance(term, str):
                    binding = {**binding, term: outputs[str(variable)]}
        return binding

    def _draw(self, instance: Instance, state: State, patience: int) -> None:
        misses = 0
        while not instance.results and not instance.exhausted and misses < patience:
            misses += not self._sampling.draw(instance, tuple(state))
            if time.monotonic() > self._deadline:
                return
