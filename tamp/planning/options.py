"""How a problem is solved: options, what is kept of an earlier plan, and limits on the work."""

from __future__ import annotations

import math
import reprlib
import resource
from dataclasses import dataclass, field
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp import clock
from tamp.errors import DomainError
from tamp.planning.constraints import Constraints

if TYPE_CHECKING:
    from tamp.planning.problem import GroundAction, Solution
    from tamp.planning.search.best_first import Search


@dataclass(frozen=True)
class Reuse:
    """What may be kept of an earlier plan: the actions that are still to be done, and what is known of their values.

    Attributes:
        actions: tried first, as they are; where they no longer work, a new plan may still use their values.
        facts: facts without fluents that were certified of those values.
    """

    actions: tuple[GroundAction, ...]
    facts: tuple[tuple[Any, ...], ...]

    @staticmethod
    def after(solution: Solution, executed: int) -> Reuse:
        """What is left of a solution once its first `executed` actions are done.

        Raises:
            ValueError: where the solution has no plan.
        """
        if solution.plan is None:
            raise ValueError("there is nothing to reuse of a solution without a plan")
        return Reuse(solution.plan[executed:], solution.certified)


@dataclass(frozen=True)
class Options:
    """What the caller of `solve` wants.

    Attributes:
        max_cost: only plans that cost at most this count.
        success_cost: a plan that costs at most this ends the run; otherwise a better one is looked for.
        max_iterations: searches before giving up.
        max_memory: resident memory of the process at which to give up [MB].
        max_search_s: time of one search, after which more is sampled instead [s].
        connectors: whether moves may be left out of the search.
        lazy_tests: whether tests are only asked when a plan rests on them.
        every_stream: whether also streams are called whose promises no plan needs, as some certify more.
        tame: streams of which it is known that they certify no more than they promise.
        shorten: whether plans are improved on for a moment also where all actions cost the same.
        optimistic: whether the search may assume what streams have not given yet, also with algorithm "incremental".
        constraints: what plans must look like.
        reuse: what to keep of an earlier plan.

    Raises:
        DomainError: where a limit is no number, or another option not what it has to be.
    """

    seed: int = 0
    timeout: float = 60.0
    max_cost: float = math.inf
    success_cost: float = math.inf
    unit_costs: bool = False
    max_iterations: int = 1_000_000
    max_memory: float = math.inf
    max_search_s: float = math.inf
    connectors: bool = True
    lazy_tests: bool = True
    every_stream: bool = False
    tame: frozenset[str] = frozenset()
    shorten: bool = False
    optimistic: bool = False
    constraints: Constraints = field(default_factory=Constraints)
    reuse: Reuse | None = None

    def __post_init__(self) -> None:
        for name in ("timeout", "max_cost", "success_cost", "max_iterations", "max_memory", "max_search_s"):
            value = getattr(self, name)
            if not isinstance(value, Real) or math.isnan(value):
                raise DomainError(f"{name} is {value!r}; valid are numbers, and math.inf for no limit")
        for name, kind, valid in (
            ("seed", Integral, "whole numbers"),
            ("constraints", Constraints, "Constraints()"),
            ("reuse", Reuse | None, "what Reuse.after makes of a solution, and None"),
        ):
            if not isinstance(value := getattr(self, name), kind):
                raise DomainError(f"{name} is {reprlib.repr(value)}; valid are {valid}")


@dataclass(frozen=True)
class Settings:
    """How each question of a run is answered: the algorithm and the search by name, and the options."""

    algorithm: str = "adaptive"
    search: str | Search = "ff"
    options: Options = field(default_factory=Options)


class Ended(Exception):  # noqa: N818  control flow inside this package, never seen outside
    """The run is over: time or iterations are used up, or infeasibility is proven."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status = status
        self.message = message


class Restart(Exception):  # noqa: N818  control flow inside this package, never seen outside
    """A simplification does not fit the problem: the run begins again with these options."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self.options = options


class Limits:
    """Counts searches, and ends the run where a limit is reached.

    Attributes:
        deadline: when the run must end, on the clock of tamp.clock.now() [s].
    """

    def __init__(self, options: Options, started: float) -> None:
        self.deadline = started + options.timeout
        self.iterations = 0
        self._options = options

    @property
    def left(self) -> float:
        """How much time is left [s]."""
        return self.deadline - clock.now()

    @property
    def left_to_search(self) -> float:
        """How much time one search may take [s]."""
        return min(self.left, self._options.max_search_s)

    def check(self) -> None:
        """End the run where a limit is reached.

        Raises:
            Ended: with the status to report.
        """
        options = self._options
        if self.left <= 0.0:
            raise Ended("timeout", f"The time limit of {options.timeout:g} s was reached.")
        if self.iterations >= options.max_iterations:
            raise Ended("failed", f"The limit of {options.max_iterations} iterations was reached.")
        if options.max_memory < math.inf and resident_mb() >= options.max_memory:
            raise Ended("failed", f"The memory limit of {options.max_memory:g} MB was reached.")


def resident_mb() -> float:
    """How much memory this process holds now [MB]; as far as the system does not say, the most that it ever held."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except FileNotFoundError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return pages * resource.getpagesize() / 1e6
