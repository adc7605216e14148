"""Corruptions of releases: where, on what, and how the hand leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Move, Plan, Release, Task
from tests.checking.mutations.editing import Pair, choose, put, put_action, shifted, sideways, step_at, steps_of


def place_in_the_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Let go above the support, and meant to stay there."""
    where = choose(steps_of(plan, Release), rng)
    if where is None:
        return None
    release = step_at(plan, where)
    up = np.array([0.0, 0.0, rng.uniform(0.02, 0.1)])
    return task, put(plan, where, replace(release, pose=shifted(release.pose, up)))


def drop_from_height(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object is let go before it has been lowered."""
    where = choose(steps_of(plan, Move, "lower"), rng)
    if where is None:
        return None
    i, j = where
    rest = plan.actions[i].steps[j + 1 :]
    if not rest or not isinstance(rest[0], Release):
        return None
    lower = step_at(plan, where)
    empty = replace(lower, phase="retreat", held=None, opening=rest[0].opening, contacts=frozenset())
    action = replace(plan.actions[i], steps=(*plan.actions[i].steps[:j], rest[0], empty, *rest[1:]))
    return task, put_action(plan, i, action)


def place_elsewhere(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The object is said to stand where the hand never was; its goal moves along."""
    where = choose(steps_of(plan, Release), rng)
    if where is None:
        return None
    release = step_at(plan, where)
    pose = shifted(release.pose, sideways(rng, 0.025, 0.2))
    return task, put(plan, where, replace(release, pose=pose))


def half_off_the_table(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The table ends under an object that is put down."""
    name = choose([n for n in sorted(plan.goals) if abs(plan.goals[n].xyz[2]) < 0.2], rng)
    places = [w for w in steps_of(plan, Release) if step_at(plan, w).object == name]
    if not places or plan.actions[places[-1][0]].name != "place":
        return None
    y = step_at(plan, places[-1]).pose.xyz[1]
    table = task.table
    low, high = table.center[1] - table.size[1] / 2, table.center[1] + table.size[1] / 2
    low, high = (low, y - rng.uniform(0.012, 0.02)) if y > 0 else (y + rng.uniform(0.012, 0.02), high)
    table = replace(table, center=(table.center[0], (low + high) / 2), size=(table.size[0], high - low))
    return replace(task, table=table), plan


def forget_to_retreat(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The hand stays round what it has put down."""
    where = choose(steps_of(plan, Move, "retreat"), rng)
    return None if where is None else (task, put(plan, where))


def release_another(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """An object that nobody holds is moved."""
    where = choose(steps_of(plan, Release), rng)
    if where is None or len(task.objects) < 2:
        return None
    release = step_at(plan, where)
    name = choose([o.name for o in task.objects if o.name != release.object], rng)
    return task, put(plan, where, replace(release, object=name))


def creep(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What is let go is said to stand a few millimetres aside."""
    where = choose(steps_of(plan, Release), rng)
    if where is None:
        return None
    release = step_at(plan, where)
    return task, put(plan, where, replace(release, pose=shifted(release.pose, sideways(rng, 0.007, 0.014))))
