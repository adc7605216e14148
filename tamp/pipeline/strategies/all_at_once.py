"""The plainest strategy: everything that a task asks for in one question to the stream planner."""

from __future__ import annotations

from collections.abc import Mapping

from tamp.pipeline.strategies.known import NOTHING, Known
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.goal_graph import all_goals
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import Asker, reason
from tamp.planning import Report, Solution, combined
from tamp.planning.strategies.strategy import Strategy
from tamp.scoring import score
from tamp.streams.values import Placement

FEW = 12  # iterations before objects may reach their goals by two grasps
UNLIMITED = 1_000_000  # iterations: only the clock ends the search


class AllAtOnce:
    """One search for all goals; where the checker refuses its plan, another with other samples.

    Args:
        attempt: the state it starts from.
        seed: decides every random choice.
        deadline: on the clock of tamp.clock.now() [s].
        algorithm: of the stream planner.
        known: of single objects, which it does not look at.
        strategy: of the stream planner, by which it answers each question; None for its own.
    """

    strategy: str | Strategy = "all-at-once"
    # What few searches find by single grasps is not worth looking for two that take turns.
    questions: tuple[tuple[int, bool], ...] = ((FEW, False), (UNLIMITED, True))

    def __init__(
        self,
        attempt: Attempt,
        seed: int,
        deadline: float,
        algorithm: str,
        known: Known = NOTHING,
        strategy: Strategy | None = None,
    ) -> None:
        self.strategy = strategy or self.strategy
        self._asker = Asker(Progress(attempt), seed, deadline, algorithm)
        self.left = dict.fromkeys(all_goals(attempt.workspace), "no time was left to plan for it")
        self.hopeless: Mapping[str, tuple[Placement, str]] = {}
        self.unturned: Mapping[str, Placement] = {}

    @property
    def progress(self) -> Progress:
        """The plan so far."""
        return self._asker.progress

    @property
    def report(self) -> Report:
        """Of all searches in sum; its status is that of the last."""
        reports = self._asker.reports
        if not reports:
            return Report(self._asker.algorithm, "timeout", 0.0, 0.0, {}, (), (), message="No time was left to search.")
        return combined(reports, reports[-1].status if not self.left or reports[-1].status != "solved" else "failed")

    @property
    def cut_short(self) -> bool:
        """Whether time was up."""
        return self._asker.late or any(report.status == "timeout" for report in self._asker.reports)

    def run(self, *, persistent: bool = False) -> None:
        """Search until there is a plan that the checker accepts, until it is proven that there is none, or time is up.

        Args:
            persistent: makes no difference here.
        """
        refused = None
        while not self._asker.late:
            solution = self._answer()
            if solution.plan is None:
                before = f"; the plan before was refused: {refused}" if refused else ""
                self.left = dict.fromkeys(self.left, reason(solution) + before)
                return
            refused = self._asker.refused(solution.plan) if solution.plan else None
            if refused is None:
                self.left = self._missed()
                return
            self.left = dict.fromkeys(self.left, refused)

    def _answer(self) -> Solution:
        """The first plan that one of the questions brings, or why the last one brings none."""
        workspace = self._asker.workspace
        for iterations, either in self.questions if workspace.goals else self.questions[-1:]:
            solution = self._asker.ask(workspace, iterations, None, strategy=self.strategy, either=either)
            if solution.plan is not None:
                break
        return solution

    def _missed(self) -> dict[str, str]:
        """The goals that the plan gives up."""
        return {}


class NetBenefit(AllAtOnce):
    """The same with soft goals: a plan that reaches those which together take most off the task's error."""

    strategy = "net-benefit"

    def _answer(self) -> Solution:
        """The best of what the questions bring, up to the first plan that gives up nothing."""
        answers: list[Solution] = []
        workspace = self._asker.workspace
        for iterations, either in self.questions if workspace.goals else self.questions[-1:]:
            answers.append(self._asker.ask(workspace, iterations, None, strategy=self.strategy, either=either))
            if answers[-1].plan is not None and not answers[-1].forgone:
                break
        return min(reversed(answers), key=lambda answer: answer.cost)

    def _missed(self) -> dict[str, str]:
        now = self.progress.now
        there = {name for name, goal in now.workspace.goals.items() if now.workspace.start[name] == goal}
        poses = {name: place.pose for name, place in now.workspace.start.items()}
        met = score(now.setup.task, poses, now.facts).goals_met
        there |= {name for name in self.left if name not in now.workspace.goals and met.get(name)}
        why = "it is out of reach, or worth less than what it stands in the way of"
        return {name: why for name in self.left if name not in there}
