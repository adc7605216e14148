"""Corruptions of grips and of what the hand holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Attachment, Grip, Move, Plan, Release, Task
from tests.checking.mutations.editing import Pair, choose, put, shifted, sideways, stand, step_at, steps_of


def regrip(task: Task, plan: Plan, where: tuple[int, int], attachment: Attachment, width: float) -> Plan:
    """The plan with another grip and the same hold in the motions that follow, up to the release."""
    plan = put(plan, where, Grip(attachment, width))
    for other in steps_of(plan, Move):
        if other > where and (move := step_at(plan, other)).held is not None:
            plan = put(plan, other, replace(move, held=attachment))
        elif other > where:
            break
    return plan


def grasp_beside(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object is elsewhere in the hand than where it stands."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip = step_at(plan, where)
    T = shifted(grip.attachment.T_tool_object, sideways(rng, 0.005, 0.05))
    return task, regrip(task, plan, where, replace(grip.attachment, T_tool_object=T), grip.width)


def grasp_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object stands beside the place where the fingers close; task and plan agree on that."""
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    name = step_at(plan, where).attachment.object
    if any(step_at(plan, w).attachment.object == name for w in steps_of(plan, Grip) if w < where):
        return None
    pose = shifted(plan.start[name], sideways(rng, 0.1, 0.2))
    return stand(task, plan, name, pose)


def wrong_width(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    if where is None:
        return None
    grip = step_at(plan, where)
    by = rng.uniform(0.01, 0.03) * (1 if grip.width < 0.04 else -1)
    return task, put(plan, where, replace(grip, width=grip.width + by))


def wrong_object(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    if where is None or len(task.objects) < 2:
        return None
    grip = step_at(plan, where)
    name = choose([o.name for o in task.objects if o.name != grip.attachment.object], rng)
    return task, regrip(task, plan, where, replace(grip.attachment, object=name), grip.width)


def keep_holding(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The fingers never open."""
    where = choose(steps_of(plan, Release), rng)
    return None if where is None else (task, put(plan, where))


def never_grip(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Grip), rng)
    return None if where is None else (task, put(plan, where))


def slip_in_hand(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The held object jumps within the hand between two motions."""
    where = choose(steps_of(plan, Move, "transfer", "lower"), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    T = shifted(move.held.T_tool_object, rng.normal(size=3) * 0.01)
    return task, put(plan, where, replace(move, held=replace(move.held, T_tool_object=T)))
