"""The protocol of strategies."""

from __future__ import annotations

import inspect
from dataclasses import asdict, is_dataclass
from typing import Any, ClassVar, Protocol

from tamp.planning.options import Settings
from tamp.planning.problem import Problem, Solution


class Strategy(Protocol):
    """Asks a stream planner one or more questions, and makes one solution of the answers.

    A strategy is a frozen dataclass: its fields are its options, which are recorded with each report.

    Attributes:
        name: what it is called where it is chosen.
        supports_soft_goals: whether it plans for the `soft_goals` of a problem; a class without it does not.
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


def misfit(strategy: object) -> str:
    """Why something cannot be asked as a strategy is; empty where it can."""
    if inspect.isclass(strategy):
        return f"is the class {strategy.__qualname__}; give an instance, such as {strategy.__qualname__}()"
    if not callable(strategy):
        return "cannot be called; a strategy is called with (problem, settings)"
    try:
        inspect.signature(strategy).bind(None, None)
    except TypeError as error:
        return f"must take (problem, settings): {error}"
    if not is_dataclass(strategy) or not strategy.__dataclass_params__.frozen:
        return "is no frozen dataclass, whose fields are its options: put @dataclass(frozen=True) before its class"
    if not isinstance(getattr(strategy, "name", None), str):
        return 'has no name; give its class one, as in name: ClassVar[str] = "mine"'
    return ""


def supports_soft_goals(strategy: object) -> bool:
    """Whether a strategy plans for the soft goals of a problem, by what it says of itself."""
    return bool(getattr(strategy, "supports_soft_goals", False))


def record(strategy: Strategy) -> dict[str, Any]:
    """A strategy's name and options, for the report."""
    return {"name": strategy.name, **asdict(strategy)}  # type: ignore[call-overload]
