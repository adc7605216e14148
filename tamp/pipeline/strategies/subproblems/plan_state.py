"""The state that a plan leaves, written as the plan of which nothing is left, and whether another one begins there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from tamp.task import Action, Fall, Grip, Move, Plan, Pose, Release
from tamp.world.robot.model import RobotModel

SAME = 1e-6  # joint angles [rad], positions [m] and rotations whose entries differ by less are one


def after(robot: RobotModel, plan: Plan) -> Plan:
    """The plan of which nothing is left, from the state that it leaves."""
    start, home = dict(plan.start), np.array(plan.home)
    for step in plan.steps:
        if isinstance(step, Release | Fall):
            start[step.object] = step.pose
        elif isinstance(step, Move):
            home = step.trajectory.positions[-1]
            if step.pushed is not None:
                start[step.pushed.object] = Pose.from_matrix(robot.forward(home)) @ step.pushed.T_tool_object
    return replace(plan, start=start, home=tuple(float(q) for q in home), actions=())


def begins_at(plan: Plan, state: Plan) -> bool:
    """Whether a plan begins where another one does."""
    same_arm = np.allclose(plan.home, state.home, rtol=0.0, atol=SAME)
    return same_arm and all(
        np.allclose(plan.start[name].matrix, state.start[name].matrix, rtol=0.0, atol=SAME) for name in plan.start
    )


def errands(actions: tuple[Action, ...]) -> Iterator[tuple[Action, ...]]:
    """The actions of a plan, in groups after each of which the hand holds nothing."""
    errand: list[Action] = []
    held = False
    for action in actions:
        errand.append(action)
        for step in action.steps:
            held = isinstance(step, Grip) or (held and not isinstance(step, Release))
        if not held:
            yield tuple(errand)
            errand = []
    if errand:
        yield tuple(errand)


def ending_with(plan: Plan, fallen: Mapping[str, Pose]) -> Plan:
    """A plan that says in the end where objects have come to that gave way to it (world frame)."""
    if not fallen:
        return plan
    *actions, last = plan.actions
    falls = tuple(Fall(name, pose) for name, pose in fallen.items())
    return replace(plan, actions=(*actions, replace(last, steps=(*last.steps, *falls))))
