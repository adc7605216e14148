"""From a task to a plan: settle, search, time, check; a plan that the checker rejects never leaves."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from tamp.domains.tabletop import NotFree, tabletop_problem
from tamp.errors import PlanningFailure
from tamp.pipeline.attempt import Attempt, Samplers
from tamp.pipeline.partial import solve_partly
from tamp.pipeline.setup import Setup, prepare
from tamp.planning import solve as solve_problem
from tamp.task import Plan, Pose, Task, load_robot

SEARCH_SHARE = 0.9  # of the time goes to the search; timing and checking what it finds needs the rest
CHECKED_ATTEMPTS = 3  # plans offered to the checker before planning is given up


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
        PlanningFailure: where no plan was found; carries the planner's report.
    """
    deadline = time.monotonic() + timeout
    setup = prepare(task)
    home = load_robot(task.robot).home
    options: Any = {"seed": seed, "samplers": samplers, "algorithm": algorithm}
    return plan_from(setup, setup.start, home, deadline=deadline, rejections=[], **options)


def plan_from(
    setup: Setup,
    poses: Mapping[str, Pose],
    q: tuple[float, ...],
    *,
    seed: int,
    deadline: float,
    samplers: Samplers | None,
    algorithm: str,
    rejections: list[str],
) -> Plan:
    """Plan from a state in the middle of an execution; see `plan`.

    Args:
        setup: the prepared task.
        poses: object -> pose (world frame), all at rest.
        q: arm configuration [rad]; the hand is empty.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
        samplers: as for `plan`.
        algorithm: as for `plan`.
        rejections: takes up the verdict on each plan that the checker sends back; each is a bug of the planner's.

    Raises:
        PlanningFailure: where no plan was found that the checker accepts.
    """
    if time.monotonic() >= deadline:
        raise PlanningFailure("timeout", "no time was left to plan")
    attempt = Attempt.of(setup, poses, q, samplers)
    before, blocked = len(rejections), list[str]()
    for number in range(CHECKED_ATTEMPTS):
        # Attempts differ in their seed by more than any two seeds of a user's.
        solution = solve_problem(
            tabletop_problem(attempt.workspace, attempt.samplers, attempt.configuration),
            algorithm=algorithm,
            timeout=max(0.0, SEARCH_SHARE * (deadline - time.monotonic())),
            seed=seed + number * 1_000_003,
        )
        if solution.plan is None:
            raise PlanningFailure(solution.status, solution.report)
        try:
            report = {**solution.report.as_dict(), "rejected": rejections[before:], "blocked": list(blocked)}
            found, verdict = attempt.finish(solution.plan, seed, report)
        except NotFree as reason:
            blocked.append(str(reason))
            continue
        if verdict.accepted:
            return found
        rejections.append(str(verdict))
    raise PlanningFailure("rejected", "\n".join((*rejections[before:], *blocked)))


def plan_partly(
    setup: Setup,
    poses: Mapping[str, Pose],
    q: tuple[float, ...],
    *,
    seed: int,
    deadline: float,
    samplers: Samplers | None,
    algorithm: str,
    rejections: list[str],
) -> Plan:
    """Plan for as many goals as possible; the plan's report says in "left" which it leaves and why. See `plan_from`.

    Raises:
        PlanningFailure: where no plan that the checker calls executable brings anything to its goal.
    """
    if time.monotonic() >= deadline:
        raise PlanningFailure("timeout", "no time was left to plan")
    attempt = Attempt.of(setup, poses, q, samplers)
    end = time.monotonic() + SEARCH_SHARE * (deadline - time.monotonic())
    options: Any = {"seed": seed, "deadline": end, "algorithm": algorithm}
    partial = solve_partly(attempt.workspace, attempt.samplers, attempt.configuration, **options)
    left = "\n".join(f"{name}: {why}" for name, why in partial.left.items())
    if not partial.actions:
        raise PlanningFailure("failed", left)
    try:
        found, verdict = attempt.finish(partial.actions, seed, {"left": dict(partial.left), "rejected": []})
    except NotFree as reason:
        raise PlanningFailure("rejected", reason) from reason
    if not verdict.executable:
        rejections.append(str(verdict))
        raise PlanningFailure("rejected", verdict)
    return found
