"""The strategies by name: which part of a task the stream planner is asked next."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Protocol

from tamp.pipeline.options.own import load_strategy
from tamp.pipeline.strategies.all_at_once import AllAtOnce, NetBenefit
from tamp.pipeline.strategies.known import NOTHING, Known
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.planning import Report
from tamp.planning.strategies.strategy import supports_soft_goals
from tamp.streams.values import Placement


class Search(Protocol):
    """A search for a plan from one state."""

    @property
    def left(self) -> Mapping[str, str]:
        """Goals that the plan does not reach -> why."""

    @property
    def progress(self) -> Progress:
        """The plan so far."""

    @property
    def report(self) -> Report:
        """Of all that was asked, in sum."""

    @property
    def cut_short(self) -> bool:
        """Whether time was up for any of it, so that more time may find more."""

    @property
    def hopeless(self) -> Mapping[str, tuple[Placement, str]]:
        """Objects that do not reach their goals even with all others out of the way -> from where, and why."""

    @property
    def unturned(self) -> Mapping[str, Placement]:
        """Objects that two grasps do not turn over -> from where."""

    def run(self, *, persistent: bool = False) -> None:
        """Reach as many goals as the time allows; `persistent` seeks a plan for all of them until time is up."""


class Strategy(Protocol):
    """Begins such a search."""

    def __call__(
        self,
        attempt: Attempt,
        seed: int,
        deadline: float,
        algorithm: str,
        known: Known = NOTHING,
    ) -> Search:
        """A search from an attempt's state, until a deadline on the clock of tamp.clock.now() [s]."""


STRATEGIES: Mapping[str, Strategy] = {"all-at-once": AllAtOnce, "serialized": Ordering, "net-benefit": NetBenefit}


def strategy_named(name: str) -> Strategy:
    """One of these, or a strategy of the stream planner's own kind that is asked for all goals at once.

    One that supports soft goals is asked for them as soft ones.

    Raises:
        TampError: where there is no such strategy.
    """
    if name in STRATEGIES:
        return STRATEGIES[name]
    own = load_strategy(name, (*STRATEGIES,))
    return partial(NetBenefit if supports_soft_goals(own) else AllAtOnce, strategy=own)
