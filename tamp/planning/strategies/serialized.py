"""Goals one after the other: each is asked for together with those that were reached before.

    serialized(problem):
        waiting <- the conjuncts of the goal;  reached <- [];  plan <- []
        for budget in ladder:                                  # each rung gives a goal more time than the last
            for goal in waiting:
                answer <- solve(reached + [goal], from the present state, within budget)
                if solved: commit;  plan <- plan + answer;  move goal from waiting to reached
            if nothing waits: return plan
            if nothing was reached on this rung, and the last one is taken: break
        answer <- solve(all goals, from the present state, within half of what is left)
        if not solved: forget the plan;  answer <- solve(all goals, from the start, within what is left)

Goals that were reached may be given up within a plan as long as they hold again at its end. A state from which the rest
cannot be reached is left by the last line, so that nothing is lost but time: what is solved at once is solved here, and
"infeasible" is said only of the whole goal from the start. What streams gave for one goal is there for the next
(`PlanningRun`). The precedent is PDDLStream's `algorithms/serialized.py`; serialization of goals goes back to Korf,
"Planning as search: a quantitative approach" (1987).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from tamp import clock
from tamp.errors import DomainError
from tamp.language import Constant
from tamp.planning.options import Settings
from tamp.planning.problem import GroundAction, Problem, Solution
from tamp.planning.report import combined
from tamp.planning.run import PlanningRun


@dataclass(frozen=True)
class Serialized:
    """Ask for goals one after the other, in the order in which they are given.

    Attributes:
        ladder: shares of the whole time limit that one goal gets, on each rung in turn.
    """

    ladder: tuple[float, ...] = (0.02, 0.08, 0.2)
    name: ClassVar[str] = "serialized"

    def __post_init__(self) -> None:
        if not self.ladder or not all(0.0 < share <= 1.0 for share in self.ladder):
            raise DomainError(f"Serialized: ladder must be shares of the time limit in (0, 1], found {self.ladder!r}")

    def __call__(self, problem: Problem, settings: Settings) -> Solution:
        """Solve a problem goal by goal.

        Raises:
            DomainError: where a skeleton, a bound of the cost or an earlier plan is given, which are about whole plans.
        """
        options = settings.options
        bounded = min(options.max_cost, options.success_cost) < math.inf
        if options.constraints.alternatives or options.reuse is not None or bounded:
            raise DomainError(
                "strategy 'serialized': a skeleton, reuse, max_cost and success_cost are about a whole plan; "
                "use strategy 'all-at-once' with them"
            )
        return _Course(problem, settings, self.ladder).run()


def conjuncts(goal: Any) -> tuple[Any, ...]:
    """The parts of a goal that all must hold."""
    if isinstance(goal, tuple | list) and goal and isinstance(goal[0], str) and goal[0].lower() == "and":
        return tuple(inner for part in goal[1:] for inner in conjuncts(part))
    return () if goal is None or goal == () else (goal,)


class _Interrupted(Exception):  # noqa: N818  control flow inside this module
    """Whoever asks wants no more."""


class _Course:
    """One problem being solved goal by goal."""

    def __init__(self, problem: Problem, settings: Settings, ladder: Sequence[float]) -> None:
        self._problem = problem
        self._limit = settings.options.timeout
        self._ladder = ladder
        self._deadline = clock.now() + self._limit
        self._run = PlanningRun(problem, settings, until=self._deadline)
        self._answers: list[Solution] = []
        self._plan: list[GroundAction] = []
        self._cost = 0.0
        self._last: Solution | None = None

    def run(self) -> Solution:
        try:
            self._pursue()
        except _Interrupted:  # plans for some of the goals are none for all
            assert self._last is not None
            self._last = replace(self._last, plan=None, cost=math.inf)
        return self._solution()

    def _pursue(self) -> None:
        waiting = list(conjuncts(self._problem.goal))
        reached: list[Any] = []
        for share in self._ladder if len(waiting) > 1 else ():
            for goal in list(waiting):
                if self._left() <= 0.0:
                    break
                if self._ask([*reached, goal], min(share * self._limit, self._left())):
                    waiting.remove(goal)
                    reached.append(goal)
            if not waiting:
                return
        if reached and self._left() > 0.0 and self._ask(None, self._left() / 2):
            return
        for _ in reached:
            self._run.rollback()
        self._plan, self._cost = [], 0.0
        if self._last is None or self._left() > 0.0:
            self._ask(None, max(0.0, self._left()))

    def _left(self) -> float:
        return self._deadline - clock.now()

    def _ask(self, goals: list[Any] | None, budget: float) -> bool:
        """Ask for goals, or all of them; commit what was found."""
        answer = self._run.solve(None if goals is None else ("and", *goals), budget=budget)
        self._answers.append(answer)
        self._last = answer
        if answer.status == "interrupted":
            raise _Interrupted
        if answer.plan is None:
            return False
        self._run.commit()
        self._plan += answer.plan
        self._cost += answer.cost
        return True

    def _solution(self) -> Solution:
        """The answers as one."""
        assert self._last is not None
        last = self._last
        if not self._plan and self._left() <= 0.0 and (last.plan or last.status == "timeout"):
            message = f"The time limit of {self._limit:g} s was reached."
            last = replace(last, plan=None, cost=math.inf, status="timeout")
        else:
            message = last.report.message
        report = replace(
            combined([answer.report for answer in self._answers], last.status),
            cost=self._cost if last.plan is not None else math.inf,
            message=message,
            skeletons=tuple(_skeletons(self._answers)),
        )
        if last.plan is None:
            return replace(last, report=report)
        facts = {(f[0], *map(Constant, f[1:])): f for answer in self._answers for f in answer.certified}
        plan, certified = tuple(self._plan), tuple(facts.values())
        return replace(last, plan=plan, cost=self._cost, certified=certified, report=report)


def _skeletons(answers: Sequence[Solution]) -> Iterator[Any]:
    for answer in answers:
        yield from answer.report.skeletons
