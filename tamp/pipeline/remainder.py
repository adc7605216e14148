"""What is still good of a plan when an object is off: actions that are left and that the checker still accepts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from tamp.checking import check
from tamp.execution.record import Execution
from tamp.task import Action, Fall, Move, Plan, Pose, Release, Task

BETWEEN_ACTIONS = ("misplaced", "disturbed")  # deviations that stop an execution after an action, not in it
SAME_CONFIGURATION = 0.02  # how far the arm may stand from where the next action begins [rad]


def still_good(task: Task, plan: Plan, execution: Execution) -> Plan | None:
    """The rest of a plan whose execution stopped, up to the first object that can no longer be moved as planned.

    Returns:
        A plan from the state as it is, accepted by the checker, that ends with an empty hand; None where nothing of it
        is left.
    """
    rest = remainder(plan, execution)
    if rest is None:
        return None
    verdict = check(task, rest, start=rest.start, goals=rest.goals)
    wrong = [problem.action for problem in verdict.problems if problem.kind != "goal"]
    if None in wrong:
        return None
    end = min((action for action in wrong if action is not None), default=len(rest.actions))
    if end < len(rest.actions):
        end = max((i + 1 for i in range(end) if _put_down(rest.actions[i : i + 1])), default=0)
    return replace(rest, actions=rest.actions[:end]) if end else None


def remainder(plan: Plan, execution: Execution) -> Plan | None:
    """All of the rest, good or not.

    What is off is taken as it is, everything else as the plan has it: it is there within what executions tolerate.

    Returns:
        None where nothing is left, or where the plan stopped within an action or the arm had to leave its way.
    """
    done, left = plan.actions[: len(execution.log)], plan.actions[len(execution.log) :]
    if execution.deviation is None or execution.deviation.kind not in BETWEEN_ACTIONS or not left:
        return None
    home = _configuration(plan, done)
    if np.abs(np.array(home) - execution.configuration).max() > SAME_CONFIGURATION:
        return None
    start = {**plan.start, **_left(done, execution.final_poses)}
    off = {deviation.object for deviation in execution.log[-1].deviations}
    start |= {name: execution.final_poses[name] for name in sorted(off)}
    return replace(plan, start=start, home=home, actions=left)


def _put_down(actions: Iterable[Action]) -> list[Release | Fall]:
    return [step for action in actions for step in action.steps if isinstance(step, Release | Fall)]


def _left(done: Iterable[Action], seen: Mapping[str, Pose]) -> dict[str, Pose]:
    """Object -> where some actions have left it: as the plan has it, or, where it was pushed to, as it is seen."""
    left: dict[str, Pose] = {}
    for step in (step for action in done for step in action.steps):
        if isinstance(step, Release | Fall):
            left[step.object] = step.pose
        elif isinstance(step, Move) and step.pushed is not None:
            left[step.pushed.object] = seen[step.pushed.object]
    return left


def _configuration(plan: Plan, done: Iterable[Action]) -> tuple[float, ...]:
    """Where the arm is after some actions [rad]."""
    moves = [step for action in done for step in action.steps if isinstance(step, Move)]
    return tuple(float(q) for q in moves[-1].trajectory.positions[-1]) if moves else plan.home
