"""What the caller of the planner wants, and how a run ends."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from tamp.planning.constraints import Constraints, Reuse


@dataclass(frozen=True)
class Options:
    """What the caller of `solve` wants.

    Attributes:
        max_cost: only plans that cost at most this count.
        success_cost: a plan that costs at most this ends the run; otherwise a better one is looked for.
        max_iterations: searches before giving up.
        max_memory: resident memory of the process at which to give up [MB].
        connectors: whether moves may be left out of the search.
        lazy_tests: whether tests are only asked when a plan rests on them.
        constraints: what plans must look like.
        reuse: what to keep of an earlier plan.
    """

    seed: int = 0
    timeout: float = 60.0
    max_cost: float = math.inf
    success_cost: float = math.inf
    unit_costs: bool = False
    max_iterations: int = 1_000_000
    max_memory: float = math.inf
    connectors: bool = True
    lazy_tests: bool = True
    constraints: Constraints = field(default_factory=Constraints)
    reuse: Reuse | None = None


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
