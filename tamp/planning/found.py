"""The best plan found so far, and what a better one may cost."""

from __future__ import annotations

import math

from tamp.planning.attempt import Attempt, BoundStep
from tamp.planning.costs import Costs
from tamp.planning.options import Ended, Options


class Found:
    """Keeps the best plan.

    Attributes:
        best: its bound actions; None where there is none yet.
        cost: of the best plan.
    """

    def __init__(self, options: Options, costs: Costs) -> None:
        self.best: tuple[BoundStep, ...] | None = None
        self.cost = math.inf
        self._options = options
        self._costs = costs

    def take(self, attempt: Attempt) -> None:
        """Keep what an attempt gave where it is better.

        Raises:
            Ended: where it is good enough.
        """
        if attempt.steps is None:
            return
        cost = self._costs.of_plan(attempt.steps)
        if cost <= self._options.max_cost and cost < self.cost:
            self.best, self.cost = attempt.steps, cost
            self._costs.prefer_cheap()
        if self.best is not None and self.cost <= self._options.success_cost:
            raise Ended("solved", "")

    def bound(self) -> int | None:
        """The search cost at which a plan can no longer be better than the best, or allowed; None where any may be."""
        limit = min(self._options.max_cost, self.cost)
        return None if limit == math.inf else math.ceil(self._costs.scale * limit) + (limit < self.cost)
