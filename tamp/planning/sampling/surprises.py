"""Streams that may certify more than they promise: each is called until it has shown whether it does.

Nothing can be concluded from what a stream promises before that, also of streams that no plan seems to need.
"""

from __future__ import annotations

from collections.abc import Container

from tamp.planning.model.external import External
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.normal_form import Condition
from tamp.planning.model.state import State
from tamp.planning.model.stream_instances import Instance
from tamp.planning.options import Limits
from tamp.planning.sampling.evaluation import Evaluator
from tamp.planning.sampling.stream_calls import Sampling


class Surprises:
    """Looks for further facts where a stream was not called yet."""

    def __init__(self, knowledge: Knowledge, sampling: Sampling, evaluator: Evaluator, limits: Limits) -> None:
        self._knowledge = knowledge
        self._sampling = sampling
        self._evaluator = evaluator
        self._limits = limits

    def look(self, besides: Container[str] = ()) -> bool:
        """Call what has not shown how it answers; whether any of it was called or may still surprise.

        Args:
            besides: streams that are called anyway, round by round, but for those that are told the state.

        Raises:
            Ended: at a limit.
        """
        called = False
        for external in self._knowledge.schema.externals.values():
            if external.name in besides and not external.fluents:
                continue
            condition = Condition(positive=external.domain + external.awaited)
            state = State(self._knowledge.state)
            for binding, _ in self._evaluator.satisfy(condition, {}, state):
                if external.name in self._sampling.tame:
                    break
                instance = self._instance(external, binding)
                if not instance.exhausted:
                    self._limits.check()
                    self._sampling.draw(instance)
                    called = True
        return called

    def _instance(self, external: External, binding: dict[str, int]) -> Instance:
        """What it is called for; where it is told the state, that is the initial one."""
        fluents = self._knowledge.told(external, self._knowledge.state)
        return self._knowledge.instance(external, tuple(binding[v] for v in external.inputs), fluents)
