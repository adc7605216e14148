"""Whether a plan is worth its risk: what it brings, against what it takes apart when little time is left."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tamp.pipeline.strategies.subproblems.plan_state import after
from tamp.scoring.total_error import shortfall
from tamp.task import Action, Grip, Move, Plan, Task
from tamp.world.robot.model import RobotModel


def worth_its_risk(task: Task, robot: RobotModel, plan: Plan, failing_share: float, chance: float) -> bool:
    """Whether a plan is expected to leave the table better than it is.

    Each time the hand takes or pushes something, it may go wrong. The table stays as it was before that action, unless
    another plan brings what this one would have brought.

    Args:
        task: what is asked for.
        robot: the robot.
        plan: from the state as it is.
        failing_share: of all handlings, after which something is elsewhere than planned.
        chance: that what has gone wrong is planned for anew.
    """
    if task.goal:
        return True  # nobody can say what a symbolic goal is worth in lengths
    missing = [*stages(task, robot, plan)]
    now, in_the_end = missing[0], missing[-1]
    expected, all_well = 0.0, 1.0
    for before, action in zip(missing, plan.actions, strict=False):
        for _ in range(_handlings(action)):
            expected += all_well * failing_share * ((1.0 - chance) * before + chance * in_the_end)
            all_well *= 1.0 - failing_share
    return expected + all_well * in_the_end <= now


def _handlings(action: Action) -> int:
    """How often the hand takes or pushes something."""
    return sum(isinstance(step, Grip) or (isinstance(step, Move) and step.pushed is not None) for step in action.steps)


def stages(task: Task, robot: RobotModel, plan: Plan) -> Iterator[float]:
    """How much is missing at the start of a plan and after each of its actions, see `shortfall` [m]."""
    state = replace(plan, actions=())
    yield shortfall(task, state.start)
    for action in plan.actions:
        state = after(robot, replace(state, actions=(action,)))
        yield shortfall(task, state.start)
