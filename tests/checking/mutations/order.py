"""Corruptions of what is done in which order, and of what actions say of themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Action, Move, Plan, Task
from tests.checking.mutations.editing import Pair, choose, put, put_action, step_at, steps_of

OTHER_SIDE = {"approach": "retreat", "retreat": "approach", "lift": "lower", "lower": "lift"}


def swap_actions(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    if len(plan.actions) < 2:
        return None
    i = int(rng.integers(len(plan.actions) - 1))
    actions = list(plan.actions)
    actions[i], actions[i + 1] = actions[i + 1], actions[i]
    return task, replace(plan, actions=tuple(actions))


def drop_action(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Any action but the last, whose loss may go unnoticed where it only returns home."""
    if len(plan.actions) < 2:
        return None
    i = int(rng.integers(len(plan.actions) - 1))
    return task, replace(plan, actions=plan.actions[:i] + plan.actions[i + 1 :])


def repeat_action(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    i = choose([i for i, action in enumerate(plan.actions) if action.name != "move"], rng)
    return None if i is None else (task, replace(plan, actions=plan.actions[: i + 1] + plan.actions[i:]))


def unknown_action(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    i = int(rng.integers(len(plan.actions)))
    changed = Action("push", plan.actions[i].arguments, plan.actions[i].steps)
    return task, put_action(plan, i, changed)


def wrong_argument(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The action's name speaks of another object than its steps."""
    i = choose([i for i, action in enumerate(plan.actions) if action.arguments], rng)
    others = [o.name for o in task.objects if i is not None and o.name != plan.actions[i].arguments[0]]
    if not others:
        return None
    changed = replace(plan.actions[i], arguments=(choose(others, rng), *plan.actions[i].arguments[1:]))
    return task, put_action(plan, i, changed)


NAMESAKES = {"pick": "unstack", "unstack": "pick", "place": "stack", "stack": "place", "lay": "lay-on", "lay-on": "lay"}
"""Actions with the same steps: one is about the table, the other about an object."""


def namesake(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """An action has the name of its like, and does not say from or onto what.

    What stands on both the table and an object may be called either.
    """
    alike = [
        (i, {"table", *a.arguments[1:]}, "table" in a.arguments)
        for i, a in enumerate(plan.actions)
        if a.name in NAMESAKES
    ]
    i = choose([i for i, on, stands in alike if len(on) == 1 or not stands], rng)
    if i is None:
        return None
    action = plan.actions[i]
    return task, put_action(plan, i, Action(NAMESAKES[action.name], action.arguments[:1], action.steps))


def stop_early(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The last object stays where it is."""
    picks = [i for i, action in enumerate(plan.actions) if action.name in ("pick", "unstack")]
    return None if not picks else (task, replace(plan, actions=plan.actions[: picks[-1]]))


def misnamed_phase(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A motion is named as one of the other side of what its action does."""
    where = choose(steps_of(plan, Move, *OTHER_SIDE), rng)
    if where is None:
        return None
    move = step_at(plan, where)
    return task, put(plan, where, replace(move, phase=OTHER_SIDE[move.phase]))
