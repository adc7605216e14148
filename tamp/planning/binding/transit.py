"""Making the moves that were left out of the search: a connector from where its fluent is to where it is wanted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from tamp import clock
from tamp.planning.binding.attempt import BoundStep, FailedMove
from tamp.planning.model.analysis.transit_actions import Connector, Connectors
from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact, Pattern
from tamp.planning.model.state import State
from tamp.planning.model.stream_instances import Instance, ground
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.sampling.stream_calls import Sampling


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

    def fail(
        self,
        connector: Connector,
        binding: dict[str, int],
        facts: tuple[Fact, ...],
        reason: str,
        guessed: bool = False,
    ) -> None:
        """Note a move that is not possible, with the facts that are known, or guessed, to bar it."""
        source, target = (binding[str(p[connector.position])] for p in (connector.before, connector.after))
        self.reason = reason
        self.facts.update(dict.fromkeys(facts))
        self.failed.append(FailedMove(source, target, facts, guessed))


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
        for connector in self._connectors.connectors:
            terms = zip(connector.after[1:], target[1:], strict=True)
            start: dict[str, int] = {t: h for t, h in terms if isinstance(t, str)}
            for found, support in list(self._evaluator.satisfy(connector.fluents, start, state)):
                for complete in self._sampled(connector, connector.streams, found, state, patience, stuck):
                    if self._holds(connector, complete, state, stuck):
                        return BoundStep(connector.schema, complete)
                stuck.facts.update(dict.fromkeys(support))
        return stuck

    def place(self, target: Fact) -> int:
        """The value of the connectors' fluent in a fact of it."""
        return int(target[self._connectors.connectors[0].position])

    def _holds(self, connector: Connector, binding: dict[str, int], state: State, stuck: Stuck) -> bool:
        """Whether the rest of a connector's condition holds; what the state has to do with it where not."""
        for pattern in connector.static:
            if self._evaluator.support(ground(pattern, binding), state) is None:
                return False
        for pattern in connector.negative:
            violation = self._evaluator.violation(ground(pattern, binding), False, state)
            if violation is not None:
                causes = tuple(fact for fact in violation.facts if fact in state)
                stuck.fail(connector, binding, causes, violation.reason)
                return False
        return True

    def _sampled(
        self,
        connector: Connector,
        streams: tuple[tuple[External, Pattern], ...],
        binding: dict[str, int],
        state: State,
        patience: int,
        stuck: Stuck,
    ) -> Iterator[dict[str, int]]:
        """Bindings with outputs of the connector's streams; none where one of them has nothing to give."""
        if not streams:
            yield binding
            return
        external, pattern = streams[0]
        certified = next(c for c in external.certified if c[0] == pattern[0])
        terms = dict(zip(certified[1:], pattern[1:], strict=True))
        inputs = tuple(binding[str(terms[v])] for v in external.inputs)
        fluents = self._knowledge.told(external, state)
        instance = self._knowledge.instance(external, inputs, fluents)
        for outputs in self._results(instance, state, patience):
            named = dict(zip(external.outputs, outputs, strict=True))
            chosen = {t: named[str(v)] for v, t in terms.items() if v in named and isinstance(t, str)}
            yield from self._sampled(connector, streams[1:], {**binding, **chosen}, state, patience, stuck)
        if not instance.results:
            reason, causes = instance.main_reason
            facts = self._evaluator.explanations.why(instance)
            stuck.fail(connector, binding, facts, f"{external.name}: {reason}", guessed=not causes)
            stuck.facts.update(dict.fromkeys(() if causes else fluents))

    def _results(self, instance: Instance, state: State, patience: int) -> Iterator[tuple[int, ...]]:
        """Up to `patience` results of a stream, with as many calls in vain on the way."""
        if not all(map(self._evaluator.given, instance.domain)):
            return
        misses = 0
        for number in range(patience):
            while number >= len(instance.results):
                if instance.exhausted or misses >= patience or clock.now() > self._deadline:
                    return
                misses += not self._sampling.draw(instance, tuple(state))
            yield instance.results[number]
