"""One question to the stream planner: from where, for which goals, with which effort, and why it failed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from tamp import clock
from tamp.pipeline.options.own import load_search
from tamp.pipeline.options.settings import SEARCHES
from tamp.pipeline.options.tuning import Tuning
from tamp.pipeline.situation import SAME_PLACE
from tamp.pipeline.strategies.subproblems.goal_graph import away
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.planning import Context, GroundAction, Problem, Report, Reuse, Solution, solve
from tamp.planning.context import generator_for
from tamp.planning.strategies.all_at_once import AllAtOnce
from tamp.planning.strategies.net_benefit import NetBenefit
from tamp.planning.strategies.strategy import Strategy as PlannerStrategy
from tamp.planning.strategies.strategy import supports_soft_goals
from tamp.scoring.ede import ede, mean_edge
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import At

SYMBOLIC_WORTH = 500.0  # of a goal without a pose, in millimetres of error
ENOUGH = 8.0  # a plan that costs no more for each goal, an action counting as a millimetre, is not improved on
ALL = ""  # in place of an object's name, what a question is about
FIRST = AllAtOnce(shorten=False)  # one plan is as good as another where it is a part of a longer one
ANOTHER_SEED = 1_000_003  # seeds of one run differ by multiples of this, more than any two seeds of a user's


@dataclass
class Asker:
    """A plan in the making and what it takes to make it longer.

    Attributes:
        progress: the plan so far.
        seed: decides every random choice.
        deadline: on the clock of tamp.clock.now() [s].
        algorithm: of the stream planner.
        refusals: how many answers to questions about each object, or about all, were sent back; each lets the next
            question about it draw other samples.
        reports: the planner's on every question.
        unturned: objects that two grasps do not turn over, neither for their goals nor for what is near -> from where.
    """

    progress: Progress
    seed: int
    deadline: float
    algorithm: str
    refusals: Counter[str] = field(default_factory=Counter)
    reports: list[Report] = field(default_factory=list)
    unturned: dict[str, Placement] = field(default_factory=dict)

    @property
    def workspace(self) -> Workspace:
        """What stands where by now; it asks for all goals."""
        return self.progress.now.workspace

    @property
    def tuning(self) -> Tuning:
        """The numbers that a user may change."""
        return self.progress.now.setup.settings.tuning

    @property
    def late(self) -> bool:
        """Whether time is up."""
        return clock.now() >= self.deadline

    @contextmanager
    def within(self, share: float, least: float = 0.0) -> Iterator[None]:
        """Inside, only such a share of the time that is left may be used, or at least so much of it [s]."""
        final, now = self.deadline, clock.now()
        self.deadline = min(final, now + max(least, share * (final - now)))
        try:
            yield
        finally:
            self.deadline = final

    def stays_unturned(self, name: str) -> bool:
        """Whether it is known that two grasps do not turn an object over from about where it is."""
        if name not in self.unturned:
            return False
        edge = mean_edge(self.workspace.task.object(name).shape)
        return ede(edge, self.unturned[name].pose, self.workspace.start[name].pose) < SAME_PLACE

    def drawn_seed(self, about: str = ALL) -> int:
        """The seed of the next question about an object, or about all: that draws anew whatever was sent back."""
        refusals = self.refusals.total() if about == ALL else self.refusals[about]
        return self.seed + refusals * ANOTHER_SEED

    def ask(
        self,
        workspace: Workspace,
        iterations: int,
        movable: Container[str] | None,
        samplers: Mapping[str, Callable[..., Any]] | None = None,
        regrasped: Collection[str] = (),
        strategy: str | PlannerStrategy = FIRST,
        either: bool = False,
        about: str = ALL,
        known: Solution | None = None,
    ) -> Solution:
        """Plan for what a workspace asks for, from where the arm is by now.

        Args:
            workspace: the question.
            iterations: of the stream planner at most.
            movable: objects that may be moved; None for all.
            samplers: in place of the run's own.
            regrasped: objects that shall reach the goal poses asked for only by way of another placement and grasp.
            either: whether all others that shall reach goal poses may do so by way of another placement and grasp.
            about: the object that the question is for.
            known: a plan that would serve if some others were not there; its values are tried first.
            strategy: of the stream planner; for "net-benefit", and others that support soft goals, each goal is worth
                what it takes off the error.
        """
        now = self.progress.now
        posed = {name for name in regrasped if isinstance(workspace.task.object(name).goal, At)}
        waiting = {name for name, goal in workspace.goals.items() if goal != workspace.start[name]}
        problem = now.problem(workspace, samplers or {}, movable, posed & waiting, waiting - posed if either else ())
        if strategy == "net-benefit" or supports_soft_goals(strategy):
            problem = softened(problem, workspace)
            if not problem.soft_goals:
                strategy = FIRST
            elif strategy == "net-benefit":
                strategy = NetBenefit(enough=ENOUGH * len(problem.soft_goals))
        search = now.setup.settings.chosen("search")
        solution = solve(
            problem,
            algorithm=self.algorithm,
            timeout=max(0.0, self.deadline - clock.now()),
            seed=self.drawn_seed(about),
            max_iterations=iterations,
            search=search if search in SEARCHES else load_search(search, SEARCHES),
            reuse=None if known is None else Reuse.after(known, 0),
            strategy=strategy,
        )
        self.reports.append(solution.report)
        if solution.status == "interrupted":  # the planner by itself keeps what it has; here nobody asks it further
            raise KeyboardInterrupt
        return solution

    def refused(self, actions: Sequence[GroundAction], about: str = ALL, *, near: bool = False) -> str | None:
        """Add the actions for an object to the plan; what is wrong with them where the checker refuses them.

        `near`: whether they bring it merely near its goal, so that it does not matter how it comes to rest there.
        """
        refused = self.progress.take(actions, self.seed, near=near)
        self.refusals[about] += refused is not None
        return refused


def while_others_stay(
    workspace: Workspace, name: str, stream: str, keys: tuple[str, ...], seed: int, deadline: float
) -> Context:
    """What a sampler is told that is asked about an object while all others stay; stream and keys part its draws."""
    context = Context(workspace, lambda: generator_for(seed, stream, keys), deadline, seed=seed)
    context.bound = tuple(("AtPose", other, place) for other, place in workspace.start.items() if other != name)
    return context


def softened(problem: Problem, workspace: Workspace) -> Problem:
    """The problem with its goals soft, each worth the millimetres that it takes off the task's error.

    A goal that no pose measures is worth as much as one that is a bound of the score away.
    """
    worth = dict[Any, float]()
    for condition in problem.goal[1:]:
        predicate, *about = condition
        if predicate == "AtPose" and about[0] in workspace.goals:
            worth[condition] = max(1.0, 1000.0 * away(workspace, about[0]))
        elif predicate != "HandEmpty":
            worth[condition] = SYMBOLIC_WORTH
    hard = tuple(condition for condition in problem.goal[1:] if condition not in worth)
    return replace(problem, goal=("and", *hard), soft_goals=tuple(worth.items()))


@dataclass(frozen=True)
class Effort:
    """How hard a goal is tried.

    Attributes:
        iterations: of the stream planner; counts, so that a busy machine finds the same plan.
        others_move: whether other objects may be put aside.
        hopeless_too: whether goals that not even the object alone could reach are tried.
        guided: whether the values come first by which the object alone reaches its goal; what bars those has to leave.
    """

    iterations: int
    others_move: bool
    hopeless_too: bool = False
    guided: bool = False


EFFORTS = (Effort(4, False), Effort(8, True), Effort(16, True, guided=True))
LAST = (EFFORTS[-1], Effort(12, True, hopeless_too=True))  # once what they will hardly reach is near its goal


def reason(solution: Solution) -> str:
    """Where the skeleton that was tried most broke; without one, the commonest failure of any stream; in words."""
    broken = [skeleton for skeleton in solution.report.skeletons if skeleton.reason]
    if broken:
        most = max(broken, key=lambda skeleton: skeleton.attempts)
        return f"{solution.status}; {most.broke_at}: {most.reason}"
    streams = [s for s in solution.report.streams if s.failures]
    if not streams:
        return solution.status
    worst = max(streams, key=lambda s: s.failures[0][1])
    return f"{solution.status}; {worst.name}: {worst.failures[0][0]}"
