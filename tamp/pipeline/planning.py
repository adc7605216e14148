"""From a task to a plan: settle, search, time, check; a plan that the checker rejects never leaves."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from tamp.checking import check
from tamp.errors import PlanningFailure
from tamp.pipeline.attempt import Attempt, Samplers
from tamp.pipeline.ordering import Ordering
from tamp.pipeline.setup import Setup, prepare
from tamp.planning import Report
from tamp.task import Plan, Pose, Task, load_robot

SEARCH_SHARE = 0.97  # of the time goes to the search; checking what it found needs the rest


def plan(
    task: Task,
    *,
    seed: int = 0,
    timeout: float = 60.0,
    samplers: Samplers | None = None,
    algorithm: str = "adaptive",
) -> Plan:
    """Plan a task from its settled start, with the arm at home.

    Args:
        task: what is to be done.
        seed: decides every random choice.
        timeout: for everything, settling and checking included [s].
        samplers: stream name -> function or "package.module:function", in place of the domain's and the task's own.
        algorithm: of the stream planner: "adaptive", "focused" or "incremental".

    Raises:
        TaskError, RobotError, SamplerError: where the input cannot be used.
        PlanningFailure: where no plan reaches all goals; carries the planner's report.
    """
    deadline = time.monotonic() + timeout
    setup = prepare(task, deadline)
    home = load_robot(task.robot).home
    search = Planning(setup, setup.start, home, seed=seed, deadline=deadline, samplers=samplers, algorithm=algorithm)
    found = search.run(persistent=True)
    if found is None or found.report.get("left"):
        raise PlanningFailure(search.report.status, search.report)
    return found


class Planning:
    """One search for a plan from a state, which may be in the middle of an execution.

    Args:
        setup: the prepared task.
        poses: object -> pose (world frame), all at rest.
        q: arm configuration [rad]; the hand is empty.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
        samplers: as for `plan`.
        algorithm: as for `plan`.
        hopeless: objects that do not reach their goals even alone from where they stand, by earlier searches -> why.

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
        samplers: Samplers | None,
        algorithm: str,
        hopeless: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._begin, self._seed = Attempt.of(setup, poses, q, samplers, deadline), seed
        end = time.monotonic() + SEARCH_SHARE * (deadline - time.monotonic())
        self._ordering = Ordering(self._begin, seed, end, algorithm, hopeless)

    @property
    def report(self) -> Report:
        """Of the search for all goals at once."""
        return self._ordering.report

    @property
    def cut_short(self) -> bool:
        """Whether time was up for the search or for one of its questions: with more of it more may be found."""
        return self._ordering.cut_short

    @property
    def left(self) -> Mapping[str, str]:
        """Objects whose goals the plan does not reach -> why."""
        return self._ordering.left

    @property
    def hopeless(self) -> Mapping[str, tuple[Pose, str]]:
        """Objects that do not reach their goals even with all others out of the way -> from where, and why."""
        return {name: (place.pose, why) for name, (place, why) in self._ordering.hopeless.items()}

    @property
    def rejections(self) -> tuple[str, ...]:
        """The verdict on each piece of a plan that the checker sent back; each is a bug of the planner's."""
        return tuple(self._ordering.progress.rejections)

    def run(self, *, persistent: bool = False) -> Plan | None:
        """Plan for as many goals as possible; the plan's report says in "left" which it leaves and why.

        Args:
            persistent: whether a plan for all goals is sought until time is up.

        Returns:
            None where nothing can be brought further.
        """
        ordering, begin = self._ordering, self._begin
        ordering.run(persistent=persistent)
        if ordering.left and not ordering.progress.actions:
            return None
        start = {name: place.pose for name, place in begin.workspace.start.items()}
        # What cannot come nearer to its goal has where it stands for its goal.
        goals = {name: place.pose for name, place in ordering.progress.now.workspace.goals.items()}
        actions, q = tuple(ordering.progress.actions), begin.configuration.q
        task = begin.setup.task
        found = Plan(task.name, task.robot, self._seed, start, q, goals, actions, ordering.report.as_dict())
        verdict = ordering.progress.checked(found) or check(task, found, start=start, goals=goals)
        if not verdict.executable:
            raise PlanningFailure("rejected", verdict)
        missed = {problem.bodies[0]: problem.sentence for problem in verdict.problems}
        left = {**missed, **ordering.left}
        refused = {"rejected": list(self.rejections), "blocked": list(ordering.progress.blocked)}
        return replace(found, report={**found.report, **refused, "left": left})
