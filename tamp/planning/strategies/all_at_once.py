"""The whole goal in one question."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from tamp.planning.options import Settings
from tamp.planning.problem import Problem, Solution
from tamp.planning.run import PlanningRun


@dataclass(frozen=True)
class AllAtOnce:
    """Ask for the whole goal at once: complete, and the only strategy that can call a problem infeasible.

    Attributes:
        shorten: whether plans are improved on for a moment also where all actions cost the same.
    """

    shorten: bool = True
    name: ClassVar[str] = "all-at-once"

    def __call__(self, problem: Problem, settings: Settings) -> Solution:
        """Solve a problem by one question."""
        options = replace(settings.options, shorten=self.shorten)
        return PlanningRun(problem, replace(settings, options=options)).solve()
