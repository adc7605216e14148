"""The protocol of strategies."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, ClassVar, Protocol

from tamp.planning.options import Settings
from tamp.planning.problem import Problem, Solution


class Strategy(Protocol):
    """Asks a stream planner one or more questions, and makes one solution of the answers.

    A strategy is a frozen dataclass: its fields are its options, which are recorded with each report.

    Attributes:
        name: what it is called where it is chosen.
    """

    name: ClassVar[str]

    def __call__(self, problem: Problem, settings: Settings) -> Solution:
        """Solve a problem.

        Args:
            problem: what to solve.
            settings: how each question is answered. Its time limit is that of all questions together.

        Raises:
            DomainError: where the strategy cannot respect a setting, or the problem does not suit it.
        """
        ...


def record(strategy: Strategy) -> dict[str, Any]:
    """A strategy's name and options, for the report."""
    return {"name": strategy.name, **asdict(strategy)}  # type: ignore[call-overload]
