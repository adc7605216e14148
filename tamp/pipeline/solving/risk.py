"""Whether a plan is worth its risk: what it brings, against what it takes apart when little time is left."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tamp.pipeline.strategies.serialization.plan_state import after
from tamp.scoring.total_error import shortfall
from tamp.task import Grip, Move, Plan, Task
from tamp.world.robot.model import RobotModel


def worth_its_risk(task: Task, robot: RobotModel, plan: Plan, failing_share: float, chance: float) -> bool:
    """Whether a plan brings more than it is likely to cost.

    Each time the hand takes or pushes something, it may go wrong, and the table stays as it is then, unless another
    plan mends it; at the worst that is when most has been taken apart.

    Args:
        task: what is asked for.
        robot: the robot.
        plan: from the state as it is.
        failing_share: of all handlings, after which something is elsewhere than planned.
        chance: that what has gone wrong is planned for anew.
    """
    if task.goal:
        return True  # nobody can say what a symbolic goal is worth in lengths
    now, *then = stages(task, robot, plan)
    handlings = sum(
        isinstance(step, Grip) or (isinstance(step, Move) and step.pushed is not None) for step in plan.steps
    )
    failing = 1.0 - (1.0 - failing_share) ** handlings
    return not then or now - then[-1] >= failing * (1.0 - chance) * (max(then) - now)


def stages(task: Task, robot: RobotModel, plan: Plan) -> Iterator[float]:
    """How much is missing at the start of a plan and after each of its actions, see `shortfall` [m]."""
    state = replace(plan, actions=())
    yield shortfall(task, state.start)
    for action in plan.actions:
        state = after(robot, replace(state, actions=(action,)))
        yield shortfall(task, state.start)
