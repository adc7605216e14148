"""The best plan found so far (the incumbent), and what it rests on."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tamp.planning.algorithms.costs import Costs
from tamp.planning.binding.attempt import Attempt, BoundStep
from tamp.planning.binding.skeleton import Skeleton
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.objects import Fact
from tamp.planning.options import Ended, Options


@dataclass(frozen=True)
class Basis:
    """What was known when a plan was found: facts without fluents, the initial state, what streams brought into it.

    What streams say later of the start may bar the plan, and is no part of what it rests on.
    """

    real: tuple[Fact, ...]
    state: tuple[Fact, ...]
    brought: tuple[Fact, ...]


class Found:
    """Keeps the best plan.

    Attributes:
        best: its bound actions; None where there is none yet.
        cost: of the best plan.
        skeleton: of the best plan.
    """

    def __init__(self, options: Options, costs: Costs, knowledge: Knowledge) -> None:
        self.best: tuple[BoundStep, ...] | None = None
        self.skeleton: Skeleton | None = None
        self.cost = math.inf
        self._basis: Basis | None = None
        self._knowledge = knowledge
        self._options = options
        self._costs = costs

    def take(self, skeleton: Skeleton, attempt: Attempt) -> bool:
        """Keep what an attempt at a skeleton gave where it is better; whether it is."""
        if attempt.steps is None:
            return False
        cost = self._costs.of_plan(attempt.steps)
        if cost > self._options.max_cost or cost >= self.cost:
            return False
        self.best, self.cost, self.skeleton = attempt.steps, cost, skeleton
        self._basis = self._known()
        self._costs.prefer_cheap(cost, exact=True)
        return True

    def check(self) -> None:
        """End the run where the best plan is good enough.

        Raises:
            Ended: then.
        """
        if self.best is not None and self.cost <= self._options.success_cost:
            raise Ended("solved", "")

    @property
    def basis(self) -> Basis:
        """What the best plan rests on; what is known by now where there is no plan."""
        return self._basis or self._known()

    def _known(self) -> Basis:
        known = self._knowledge
        return Basis(tuple(known.real), tuple(known.state), tuple(known.brought))

    def bound(self, pairs: bool = False) -> int | None:
        """The search cost at which a plan can no longer be better than the best, or allowed; None where any may be.

        It is what the best plan costs in the search itself, lest that plan be found again and again. `pairs`: in one
        that sees what each move costs between two values.
        """
        if self.best is not None:
            return self._costs.searched(self.best, pairs)
        limit = self._options.max_cost
        return None if limit == math.inf else math.ceil(self._costs.scale * limit) + 1
