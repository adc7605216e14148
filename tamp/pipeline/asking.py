"""The stream planner, asked from where a plan in the making ends: one question after another, each with its limits."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from tamp.domains.tabletop import tabletop_problem
from tamp.pipeline.progress import Progress
from tamp.planning import GroundAction, Report, Solution, solve
from tamp.streams.workspace import Workspace

ANOTHER_SEED = 1_000_003  # seeds of one run differ by multiples of this, more than any two seeds of a user's


@dataclass
class Asker:
    """A plan in the making and what it takes to make it longer.

    Attributes:
        progress: the plan so far.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
        algorithm: of the stream planner.
        refusals: how many answers the checker has sent back; each lets the next question draw other samples.
        reports: the planner's on every question.
    """

    progress: Progress
    seed: int
    deadline: float
    algorithm: str
    refusals: int = 0
    reports: list[Report] = field(default_factory=list)

    @property
    def workspace(self) -> Workspace:
        """What stands where by now; it asks for all goals."""
        return self.progress.now.workspace

    @property
    def late(self) -> bool:
        """Whether time is up."""
        return time.monotonic() >= self.deadline

    @contextmanager
    def within(self, share: float, least: float = 0.0) -> Iterator[None]:
        """Inside, only such a share of the time that is left may be used, or at least so much of it [s]."""
        final, now = self.deadline, time.monotonic()
        self.deadline = min(final, now + max(least, share * (final - now)))
        try:
            yield
        finally:
            self.deadline = final

    @property
    def drawn_seed(self) -> int:
        """The seed of the next question."""
        return self.seed + self.refusals * ANOTHER_SEED

    def ask(
        self,
        workspace: Workspace,
        iterations: int,
        movable: Container[str] | None,
        samplers: Mapping[str, Callable[..., Any]] | None = None,
        regrasped: Collection[str] = (),
    ) -> Solution:
        """Plan for what a workspace asks for, from where the arm is by now.

        Args:
            workspace: the question.
            iterations: of the stream planner at most.
            movable: objects that may be moved; None for all.
            samplers: in place of the run's own.
            regrasped: objects that shall reach the goals asked for only by way of another placement and grasp.
        """
        now = self.progress.now
        moving = {name for name in regrasped if workspace.task.object(name).goal is not None}
        moving -= {name for name in moving if workspace.goals[name] == workspace.start[name]}
        problem = tabletop_problem(
            workspace,
            {**now.samplers, **(samplers or {})},
            now.configuration,
            movable=movable,
            regrasped=moving,
            deadline=self.deadline,
        )
        solution = solve(
            problem,
            algorithm=self.algorithm,
            timeout=max(0.0, self.deadline - time.monotonic()),
            seed=self.drawn_seed,
            max_iterations=iterations,
        )
        self.reports.append(solution.report)
        return solution

    def refused(self, actions: Sequence[GroundAction]) -> str | None:
        """Add actions to the plan; what is wrong with them where the checker refuses them."""
        refused = self.progress.take(actions, self.seed)
        self.refusals += refused is not None
        return refused
