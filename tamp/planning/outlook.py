"""When to ask whether the goal is still within reach, and what to conclude from the answer."""

from __future__ import annotations

from tamp.planning.knowledge import Knowledge
from tamp.planning.options import Ended
from tamp.planning.prospects import out_of_reach
from tamp.planning.sampling import Sampling
from tamp.planning.schema import Schema


class Outlook:
    """Looks into the prospects again whenever twice as much was sampled, so that it costs little beside sampling."""

    def __init__(self, schema: Schema, knowledge: Knowledge, sampling: Sampling) -> None:
        self._schema = schema
        self._knowledge = knowledge
        self._sampling = sampling
        self._next = 0

    def check(self) -> None:
        """End the run where the goal is out of reach.

        Raises:
            Ended: "infeasible".
        """
        if self._sampling.draws < self._next or self._may_surprise():
            return
        self._next = 2 * self._sampling.draws
        lost = out_of_reach(self._schema, self._knowledge)
        if lost is not None:
            text = self._knowledge.objects.text(lost)
            raise Ended("infeasible", f"{text} is out of reach: the streams it needs are exhausted.")

    def _may_surprise(self) -> bool:
        """Whether a stream may yet certify more than it promises: one has, or some have not shown how they answer."""
        self._knowledge.refresh()
        return self._sampling.wild or any(
            not instance.exhausted
            and instance.alive
            and all(support.alive for support in instance.supports)
            and instance.external.outputs
            and not instance.external.fluents
            and instance.external.name not in self._sampling.tame
            for instance in self._knowledge.instances()
        )
