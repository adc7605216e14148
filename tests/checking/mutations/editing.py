"""Looking up and replacing steps of a plan: what every corruption is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tamp.task import Action, Attachment, Fall, Grip, Move, Object, Plan, Pose, Release, Step, Task

Pair = tuple[Task, Plan]
Mutation = Callable[[Task, Plan, np.random.Generator], Pair | None]


def steps_of(plan: Plan, kind: type, *phases: str) -> list[tuple[int, int]]:
    """Indices (action, step) of steps of a kind, of moves in certain phases."""
    return [
        (i, j)
        for i, action in enumerate(plan.actions)
        for j, step in enumerate(action.steps)
        if isinstance(step, kind) and (not phases or (isinstance(step, Move) and step.phase in phases))
    ]


def step_at(plan: Plan, where: tuple[int, int]) -> Step:
    return plan.actions[where[0]].steps[where[1]]


def put(plan: Plan, where: tuple[int, int], *steps: Step) -> Plan:
    """The plan with one step replaced by others."""
    i, j = where
    action = plan.actions[i]
    return put_action(plan, i, replace(action, steps=(*action.steps[:j], *steps, *action.steps[j + 1 :])))


def put_action(plan: Plan, i: int, action: Action) -> Plan:
    """The plan with another action in place of its i-th."""
    return replace(plan, actions=(*plan.actions[:i], action, *plan.actions[i + 1 :]))


def changed(task: Task, name: str, **values: Any) -> Task:
    """The task with other values of an object's attributes."""
    return replace(task, objects=tuple(replace(o, **values) if o.name == name else o for o in task.objects))


def stand(task: Task, plan: Plan, name: str, pose: Pose) -> Pair:
    """Task and plan with an object that stands elsewhere at the start."""
    return changed(task, name, pose=pose), replace(plan, start={**plan.start, name: pose})


def added(task: Task, plan: Plan, thing: Object) -> Pair:
    """Task and plan with another object in them."""
    return replace(task, objects=(*task.objects, thing)), replace(plan, start={**plan.start, thing.name: thing.pose})


def recentred(plan: Plan, name: str, by: Pose) -> Plan:
    """The plan with the frame of an object elsewhere in it: at `by` in the old one."""

    def moved(attachment: Attachment | None) -> Attachment | None:
        mine = attachment is not None and attachment.object == name
        return replace(attachment, T_tool_object=attachment.T_tool_object @ by) if mine else attachment

    for where in [w for kind in (Move, Grip, Release, Fall) for w in steps_of(plan, kind)]:
        step = step_at(plan, where)
        if isinstance(step, Move):
            step = replace(step, held=moved(step.held), pushed=moved(step.pushed))
        elif isinstance(step, Grip):
            step = replace(step, attachment=moved(step.attachment))
        elif step.object == name:
            step = replace(step, pose=step.pose @ by)
        plan = put(plan, where, step)
    start, goals = ({n: p @ by if n == name else p for n, p in ps.items()} for ps in (plan.start, plan.goals))
    return replace(plan, start=start, goals=goals)


def choose(options: list, rng: np.random.Generator):
    return options[int(rng.integers(len(options)))] if options else None


def shifted(pose: Pose, by: np.ndarray) -> Pose:
    return Pose(tuple(np.array(pose.xyz) + by), pose.quat)


def sideways(rng: np.random.Generator, low: float, high: float) -> np.ndarray:
    """A horizontal vector of random direction and length [m]."""
    angle, length = rng.uniform(0, 2 * np.pi), rng.uniform(low, high)
    return length * np.array([np.cos(angle), np.sin(angle), 0.0])
