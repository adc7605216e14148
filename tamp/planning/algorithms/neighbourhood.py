"""The values of the best plan, and what streams give first for these: few enough to look for another order of actions.

A plan whose actions come in a poor order mostly has values that a better order can do with, or their like: another hand
takes the same thing from the same place (a neighbourhood as in Nakhost and Mueller, "Action elimination and plan
neighborhood graph search", ICAPS 2010, of values in place of states).
"""

from __future__ import annotations

from collections.abc import Collection

from tamp.planning.algorithms.session import Session
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.grounding.relevance import Relevance
from tamp.planning.model.stream_instances import Instance

MOST = 500
"""Actions at most that are grounded besides: more are no neighbourhood, and to ground and search them takes longer."""


class Neighbourhood:
    """One result of each stream stands for its like: that which the best plan uses, or else the first that was given.

    It is of the best plan at the time that it is made. The same value may come from streams of several inputs, for one
    of which alone it is used.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._used: set[tuple[Instance, int]] = set()
        self._values: dict[int, None] = {}
        self._apart: dict[int, bool] = {}
        for step in session.found.best or ():
            values = {h for h in step.binding.values() if not self._is_momentary(h)}
            self._values.update(dict.fromkeys(values))
            self._used.update((i, n) for h in values for i, n in self._givers(h) if values.issuperset(i.inputs))
        self._used.update((i, n) for handle in self._values for i, n in self._givers(handle)[:1])
        self._served = {instance for instance, _ in self._used}
        for handle in self._values:
            session.knowledge.show(handle)

    def ask(self, most: int) -> None:
        """Ask streams that have given nothing for values of the neighbourhood, while there are less than `most` calls.

        What the goal cannot need is not asked for: its sampler may be slow. Where pieces of what is given multiply, it
        ends at so many actions.

        Raises:
            Ended: at a limit.
        """
        session = self._session
        relevance = Relevance(session.schema, session.connectors, session.knowledge)
        asked: set[Instance] = set()
        enough = len(session.grounder.operators) + MOST
        while session.sampling.calls < most and len(session.grounder.operators) < enough:
            new = [i for i in session.knowledge.instances() if i not in asked and relevance.of(i)]
            known = [i for i in new if self._fit(i.inputs)]
            if not known:
                return
            asked.update(known)
            for instance in known:
                if len(session.grounder.operators) >= enough:
                    return
                session.rounds.ask_first((instance,), most)

    def operators(self) -> frozenset[GroundOperator]:
        """Actions with its values; what is only assumed is none, but of streams with fluents, asked in each state."""
        return frozenset(op for op in self._session.grounder.operators if self._fit(op.binding.values()))

    def _fit(self, values: Collection[int]) -> bool:
        """Whether values that something is about together are of the neighbourhood, those that they come from too."""
        together = set(values)
        return all(self._fits(handle, together) for handle in together)

    def _fits(self, handle: int, together: set[int]) -> bool:
        """Whether a value is of the neighbourhood beside others; what they give of it counts before what else does."""
        if not self._session.objects.is_real(handle):
            origin: Instance | None = self._session.objects.origin(handle)
            return origin is not None and bool(origin.external.fluents) and self._fit(origin.inputs)
        if self._is_momentary(handle):
            return False
        near = [giver for giver in self._givers(handle) if together.issuperset(giver[0].inputs)]
        return any(self._stands(i, n) for i, n in near) if near else self._holds(handle)

    def _holds(self, handle: int) -> bool:
        """Whether a value is of the neighbourhood by where it came from first; chains of values may be long."""
        pending, opened = [handle], set[int]()  # a stream may give what it was called for
        while pending:
            at = pending[-1]
            givers = self._givers(at)[:1]
            inputs = [h for i, _ in givers for h in i.inputs if h not in self._apart and h not in opened]
            if at not in opened and inputs:
                pending += inputs
            else:
                real = not givers and self._session.objects.is_real(at)
                kept = (self._stands(i, n) and all(self._apart.get(h, False) for h in i.inputs) for i, n in givers)
                self._apart[pending.pop()] = real or any(kept)
            opened.add(at)
        return self._apart[handle]

    def _is_momentary(self, handle: int) -> bool:
        """Whether a value came from a stream with fluents: what that certifies holds in the state that it was told."""
        source = self._session.knowledge.source(handle)
        return source is not None and bool(source.external.fluents)

    def _givers(self, handle: int) -> list[tuple[Instance, int]]:
        """The streams that gave a value, with the number of the result; none for one of the problem."""
        knowledge = self._session.knowledge
        return knowledge.givers(handle) if knowledge.source(handle) is not None else []

    def _stands(self, instance: Instance, number: int) -> bool:
        """Whether a result of a stream stands for its like."""
        return (instance, number) in self._used if instance in self._served else number == 0
