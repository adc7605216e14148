"""From a task to a plan: settle, search, time, check; a plan that the checker rejects never leaves."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from tamp.checking import check
from tamp.domains.samplers import resolve_samplers
from tamp.domains.tabletop import DEFAULT_SAMPLERS, NotFree, assemble, tabletop_problem
from tamp.errors import PlanningFailure
from tamp.execution.settling import settle
from tamp.pipeline.situation import Situation, observe, settled_goals
from tamp.pipeline.validity import check_geometry, check_settled
from tamp.planning import solve as solve_problem
from tamp.streams.values import Configuration, Placement
from tamp.streams.workspace import Workspace
from tamp.task import At, Plan, Pose, Task, load_robot
from tamp.task.validate import validate
from tamp.world.geometry import load_geometry
from tamp.world.robot_model import robot_model
from tamp.world.world import World

Samplers = Mapping[str, "str | Callable[..., Any]"]

CHECKED_ATTEMPTS = 3  # plans offered to the checker before planning is given up


@dataclass(frozen=True, eq=False)
class Setup:
    """A task ready to be planned: geometry, the settled start, and what the goals mean.

    Attributes:
        task: the task.
        world: its geometry and robot.
        start: object -> pose (world frame) after settling.
        goals: object with a goal pose -> the placement it comes to rest in.
    """

    task: Task
    world: World
    start: Mapping[str, Pose]
    goals: Mapping[str, Placement]


def prepare(task: Task) -> Setup:
    """Read the geometry, refuse what cannot be, and let start and goals settle.

    Raises:
        TaskError: where the task cannot be used; one sentence that says where and why.
        RobotError: where its robot cannot.
    """
    validate(task)
    world = World(
        robot_model(load_robot(task.robot)), {obj.name: load_geometry(obj.shape) for obj in task.objects}, task.table
    )
    check_geometry(task, world)
    start = settle(task).poses
    goals = settled_goals(task, world, start)
    check_settled(task, start, goals)
    return Setup(task, world, start, goals)


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
    return plan_from(setup, setup.start, home, seed=seed, deadline=deadline, samplers=samplers, algorithm=algorithm)


def plan_from(
    setup: Setup,
    poses: Mapping[str, Pose],
    q: tuple[float, ...],
    *,
    seed: int,
    deadline: float,
    samplers: Samplers | None,
    algorithm: str,
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
    """
    task = setup.task
    situation = observe(task, poses, setup.goals)
    workspace = Workspace(task, setup.world, situation.start, situation.goals)
    functions = resolve_samplers(DEFAULT_SAMPLERS, task.samplers, samplers or {})
    configuration = Configuration(tuple(q), load_robot(task.robot).gripper.stroke)
    problem = tabletop_problem(workspace, functions, configuration)
    rejected: list[str] = []
    for attempt in range(CHECKED_ATTEMPTS):
        # Attempts differ in their seed by more than any two seeds of a user's.
        solution = solve_problem(
            problem, algorithm=algorithm, timeout=max(0.0, deadline - time.monotonic()), seed=seed + attempt * 1_000_003
        )
        if solution.plan is None:
            raise PlanningFailure(solution.status, solution.report)
        try:
            actions = assemble(workspace, solution.plan)
        except NotFree as reason:
            rejected.append(str(reason))
            continue
        report = {**solution.report.as_dict(), "rejected": list(rejected)}
        found = Plan(task.name, task.robot, seed, poses, tuple(q), _goal_poses(task, situation), actions, report)
        verdict = check(task, found, start=poses, goals=_goal_poses(task, situation))
        if verdict.accepted:
            return found
        rejected.append(str(verdict))
    raise PlanningFailure("rejected", "\n".join(rejected))


def _goal_poses(task: Task, situation: Situation) -> dict[str, Pose]:
    return {obj.name: situation.goals[obj.name].pose for obj in task.objects if isinstance(obj.goal, At)}
