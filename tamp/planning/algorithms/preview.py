"""What a plan would cost at least with other values, before anything is checked of them: branch and bound's bound."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tamp.planning.algorithms.session import Session
from tamp.planning.binding.assignment import Begin
from tamp.planning.binding.attempt import BoundStep, Budget
from tamp.planning.binding.skeleton import Apply, Choose, Rewind, Skeleton
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import Instance, ground


class Preview:
    """Prices the best plan with other values for what a skeleton of it leaves open.

    Attributes:
        choices: what is left open that the cost depends on; the others, such as paths between configurations whose
            distance is paid for, need not be made to know it.
    """

    def __init__(self, session: Session, skeleton: Skeleton, budget: Budget) -> None:
        """`budget`: what an attempt to make the choices may spend."""
        self.choices = [item.template for item in skeleton.items if isinstance(item, Choose)]
        if not session.connectors.connectors:  # else it depends on which moves are needless
            self.choices = _priced(skeleton, self.choices)
        items = [i for i in skeleton.items if not isinstance(i, Choose) or i.template in self.choices]
        end = next((i for i, item in enumerate(items) if isinstance(item, Rewind)), len(items))
        early = [item for item in items[:end] if isinstance(item, Choose | Apply)]
        late = [item for item in items[end:] if isinstance(item, Choose)]
        self._session = session
        self._budget = budget
        self._choices = None if late else Skeleton(skeleton.steps, tuple(early))

    def least(self, begin: Begin, values: Mapping[int, int]) -> float:
        """The least that the plan may cost with other choices, infinity where these cannot be made.

        Args:
            begin: the choices, as the binder is told of them.
            values: placeholder -> what stands for it in the best plan.
        """
        if self._choices is None:
            return 0.0
        attempt = self._session.binder.bind(self._choices, self._budget, begin=begin)
        if attempt.steps is None:
            return math.inf
        chosen = [(old, attempt.values[p]) for p, old in values.items() if p in attempt.values]
        new = {old: value for old, value in chosen if value != old}
        kept = {old for old, value in chosen if value == old}
        steps = iter(attempt.steps)
        connectors, costs = self._session.connectors, self._session.costs
        total = 0.0
        for step in self._session.found.best or ():
            if not connectors.is_connector(step.schema.name):
                total += costs.at_least(next(steps))
            elif not kept.intersection(step.binding.values()).intersection(new):
                total += self._move(step, new)
        return total

    def _move(self, step: BoundStep, new: Mapping[int, int]) -> float:
        """The least that a move of the best plan may cost where some values are new; nothing where it is needless."""
        moved = {name: new.get(handle, handle) for name, handle in step.binding.items()}
        for connector in self._session.connectors.connectors:
            ends = [moved[str(p[connector.position])] for p in (connector.before, connector.after)]
            if connector.schema is step.schema and ends[0] == ends[1]:
                return 0.0
        stale = frozenset(h for h in step.binding.values() if h not in new and self._rests_on(h, new))
        return self._session.costs.at_least(BoundStep(step.schema, moved), stale)

    def _rests_on(self, handle: int, new: Mapping[int, int]) -> bool:
        """Whether a value was given for one that is another now."""
        source = self._session.knowledge.source(handle)
        return source is not None and any(h in new or (h < handle and self._rests_on(h, new)) for h in source.inputs)


def _priced(skeleton: Skeleton, choices: Sequence[Instance]) -> list[Instance]:
    """The choices that the costs of a skeleton's actions depend on, and those that these rest on."""
    terms = [(t, s.binding) for s in skeleton.steps for t in s.schema.cost or () if isinstance(t, tuple)]
    wanted: set[int] = {h for term, binding in terms for h in ground(term, binding)[1:]}
    facts = set[Fact]()
    found = set[Instance]()
    for choice in reversed(choices):  # each rests on earlier ones
        if wanted.intersection(choice.placeholders) or facts.intersection(choice.certified(choice.placeholders)):
            found.add(choice)
            wanted.update(choice.inputs)
            facts.update(ground(pattern, choice.binding()) for pattern in choice.external.domain)
    return [choice for choice in choices if choice in found]
