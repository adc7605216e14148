"""From a task to a plan: settle, search, time, check; a plan that the checker rejects never leaves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from numbers import Integral
from typing import Any

from typing_extensions import Unpack

from tamp.clock import TimeUp, ended_at, limits_in, now
from tamp.errors import PlanningFailure, TampError
from tamp.pipeline.loading import load_samplers
from tamp.pipeline.options.settings import Options, Settings, settings_of
from tamp.pipeline.options.trust import refuse_code
from tamp.pipeline.prepare import Setup, prepare
from tamp.pipeline.strategies.known import NOTHING, Known
from tamp.pipeline.strategies.named import strategy_named
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.planning import Report
from tamp.speculation import speculating
from tamp.task import Plan, Pose, SymbolicFact, Task, task_robot
from tamp.task.expected import expect_task
from tamp.threads import one_thread

SEARCH_SHARE = 0.97  # of the time goes to the search; checking what it found needs the rest


def plan(task: Task, *, seed: int = 0, timeout: float = 60.0, **options: Unpack[Options]) -> Plan:
    """Plan a task from its settled start, with the arm at home.

    The limit is `timeout` alone: the task's own, `limits.planning_s`, counts for `tamp.solve` and the command line.

    Args:
        task: what is to be done.
        seed: decides every random choice.
        timeout: for everything, settling and checking included, on the clock of the options [s]; it runs from when the
            samplers are imported and their models read.
        **options: the fields of `tamp.pipeline.options.settings.Settings`: samplers, domain, strategy, clock, ...

    Raises:
        TaskError, DomainError, RobotError, SamplerError: where the input cannot be used.
        PartError: where a strategy, a skill or another part of one's own raises or answers wrongly.
        TampError: where seed, timeout or an option is not valid, or poses are to be perceived.
        PlanningFailure: where no plan reaches all goals; carries the planner's report.
    """
    settings = settings_of(options)
    expect_task(task)
    refuse_arguments(seed, timeout)
    if settings.perceive is not None:
        raise TampError("a plan is made from poses that are given; perceive belongs to `tamp solve` and tamp.solve")
    refuse_code(task, settings.domain, trusted=settings.trust_task_code)
    load_samplers(task, settings)
    with limits_in(settings.clock), one_thread():
        return speculating(lambda: _planned(task, seed, timeout, settings), settings.threads)


def _planned(task: Task, seed: int, timeout: float, settings: Settings) -> Plan:
    deadline, search = now() + timeout, None
    try:
        with ended_at(deadline):
            setup = prepare(task, deadline, settings)
            home = task_robot(task).home
            search = Planning(setup, setup.start, home, seed=seed, deadline=deadline, settings=settings)
            found = search.run(persistent=True)
    except TimeUp as late:
        if search is None:
            raise PlanningFailure("timeout", str(late)) from None
        raise PlanningFailure("timeout", search.interrupted(late), search.left) from None
    status = in_all(search.report.status, used_up=now() >= deadline - (1 - SEARCH_SHARE) * timeout)
    if found is None or found.report.get("left"):
        raise PlanningFailure(status, search.report, search.left)
    return found


def refuse_arguments(seed: Any, timeout: Any) -> None:
    """Refuse what is no seed or no limit for planning; None is the task's own limit.

    Raises:
        TampError: says what would be valid.
    """
    if not isinstance(seed, Integral) or seed < 0:
        raise TampError(f"seed is {seed!r}; valid are 0, 1, 2, ...")
    if timeout is not None and not (isinstance(timeout, int | float) and timeout > 0):  # neither is NaN
        raise TampError(f"timeout is {timeout!r}; valid are positive numbers of seconds")


def in_all(status: str, *, used_up: bool) -> str:
    """What a run without a plan has come to: "timeout" says that the limit was used up, and nothing else does.

    Args:
        status: of the search that came last, which may have had a part of the time only.
        used_up: whether the limit of the whole run was.
    """
    if status == "infeasible":
        return status
    return "timeout" if used_up else "failed"


class Planning:
    """One search for a plan from a state, which may be in the middle of an execution.

    Args:
        setup: the prepared task.
        poses: object -> pose (world frame), all at rest.
        q: arm configuration [rad]; the hand is empty.
        seed: decides every random choice.
        deadline: on the clock of tamp.clock.now() [s].
        settings: how it is planned.
        known: of single objects.
        facts: symbolic facts that hold; None for those that the task starts with.

    Raises:
        PlanningFailure: where the deadline is past before the search can begin.
    """

    def __init__(
        self,
        setup: Setup,
        poses: Mapping[str, Pose],
        q: tuple[float, ...],
        *,
        seed: int,
        deadline: float,
        settings: Settings,
        known: Known = NOTHING,
        facts: tuple[SymbolicFact, ...] | None = None,
    ) -> None:
        self._begin, self._seed = Attempt.of(setup, poses, q, settings.samplers, deadline, facts), seed
        end = now() + SEARCH_SHARE * (deadline - now())
        strategy = strategy_named(setup.settings.strategy or setup.domain.strategy)
        self._search = strategy(self._begin, seed, end, settings.algorithm, known)

    @property
    def report(self) -> Report:
        """Of the search for all goals at once."""
        return self._search.report

    def interrupted(self, late: TimeUp) -> Report:
        """The report of a search that was ended in the middle."""
        return replace(self.report, status="timeout", message=str(late))

    @property
    def cut_short(self) -> bool:
        """Whether time was up for the search or for one of its questions: with more of it more may be found."""
        return self._search.cut_short

    @property
    def left(self) -> Mapping[str, str]:
        """Objects whose goals the plan does not reach -> why."""
        return self._search.left

    @property
    def hopeless(self) -> Mapping[str, tuple[Pose, str]]:
        """Objects that do not reach their goals even with all others out of the way -> from where, and why."""
        return {name: (place.pose, why) for name, (place, why) in self._search.hopeless.items()}

    @property
    def unturned(self) -> Mapping[str, Pose]:
        """Objects that two grasps do not turn over -> from where."""
        return {name: place.pose for name, place in self._search.unturned.items()}

    @property
    def rejections(self) -> tuple[str, ...]:
        """The verdict on each piece of a plan that the checker sent back; each is a bug of the planner's."""
        return tuple(self._search.progress.rejections)

    def run(self, *, persistent: bool = False) -> Plan | None:
        """Plan for as many goals as possible; the plan's report says in "left" which it leaves and why.

        Args:
            persistent: whether a plan for all goals is sought until time is up.

        Returns:
            None where nothing can be brought further.
        """
        search, begin = self._search, self._begin
        search.run(persistent=persistent)
        if search.left and not search.progress.actions:
            return None
        start = {name: place.pose for name, place in begin.workspace.start.items()}
        # What cannot come nearer to its goal has where it stands for its goal.
        goals = {name: place.pose for name, place in search.progress.now.workspace.goals.items()}
        actions, q = tuple(search.progress.actions), begin.configuration.q
        task = begin.setup.task
        found = Plan(task.name, task.robot, self._seed, start, q, goals, actions, search.report.as_dict())
        verdict = search.progress.checked(found) or begin.setup.check(
            found, start=start, goals=goals, facts=begin.facts, after=begin.judged.state
        )
        if not verdict.executable:
            raise PlanningFailure("rejected", verdict)
        missed = {problem.bodies[0]: problem.sentence for problem in verdict.problems}
        left = {**missed, **search.left}
        refused = {"rejected": list(self.rejections), "blocked": list(search.progress.blocked)}
        settled_in = begin.setup.settings.settling
        return replace(found, report={**found.report, **refused, "left": left, "settled_in": settled_in})
