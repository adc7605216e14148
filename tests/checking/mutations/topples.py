"""Corruptions of what is pushed over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.checking.scene import Scene
from tamp.task import Fall, Move, Plan, Task, Trajectory
from tests.checking.mutations.editing import Pair, changed, put, step_at, steps_of


def topple_halfway(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The hand stops before the object falls over by itself."""
    where = _topple(plan)
    if where is None:
        return None
    move = step_at(plan, where)
    t = move.trajectory
    kept = max(2, int(len(t.times) * rng.uniform(0.2, 0.6)))
    velocities = np.vstack([t.velocities[: kept - 1], np.zeros((1, t.velocities.shape[1]))])
    return task, put(plan, where, replace(move, trajectory=Trajectory(t.times[:kept], t.positions[:kept], velocities)))


def topple_on_ice(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """It stands on too little friction, and would slide away before it tips."""
    where = _topple(plan)
    if where is None:
        return None
    name, friction = step_at(plan, where).pushed.object, rng.uniform(0.02, 0.15)
    return changed(task, name, friction=friction), plan


def topple_over_the_edge(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The table ends just beyond where the centre of what falls over comes down."""
    where = _topple(plan)
    falls = [w for w in steps_of(plan, Fall) if where is not None and w > where]
    if where is None or not falls:
        return None
    fall = step_at(plan, falls[0])
    center = Scene.of(task).center_of_mass(fall.object, fall.pose.matrix)[:2]
    way = center - np.array(plan.start[fall.object].xyz[:2])
    axis = int(np.abs(way).argmax())
    middle, half = np.array(task.table.center), np.array(task.table.size) / 2
    ends = np.stack([middle - half, middle + half])
    ends[int(way[axis] > 0.0), axis] = center[axis] + np.sign(way[axis]) * rng.uniform(0.003, 0.012)
    middle, size = ends.mean(axis=0), ends[1] - ends[0]
    return replace(task, table=replace(task.table, center=tuple(middle), size=tuple(size))), plan


def _topple(plan: Plan) -> tuple[int, int] | None:
    """Where the first topple is, or None."""
    found = (w for w in steps_of(plan, Move) if plan.actions[w[0]].name == "topple" and step_at(plan, w).pushed)
    return next(found, None)
