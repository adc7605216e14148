"""Corruptions of what falls after it was let go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Fall, Move, Plan, Pose, Release, Task, Trajectory
from tests.checking.mutations.editing import Pair, choose, put, put_action, shifted, sideways, step_at, steps_of


def fall_elsewhere(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    return _fallen(task, plan, rng, sideways(rng, 0.05, 0.2))


def fall_into_the_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """It stops before it comes to rest."""
    return _fallen(task, plan, rng, np.array([0.0, 0.0, rng.uniform(0.015, 0.1)]))


def fall_into_what_carries(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    return _fallen(task, plan, rng, np.array([0.0, 0.0, -rng.uniform(0.012, 0.05)]))


def fall_up(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    return _fallen(task, plan, rng, np.array([0.0, 0.0, rng.uniform(0.2, 0.4)]))


def never_fall(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Fall), rng)
    return None if where is None else (task, put(plan, where))


def fall_late(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The arm waits before the fall."""
    where = choose(steps_of(plan, Fall), rng)
    if where is None:
        return None
    before = [w for w in steps_of(plan, Move) if w[0] == where[0] and w < where]
    if not before:
        return None
    move = step_at(plan, before[-1])
    still = np.repeat(move.trajectory.positions[-1:], 2, axis=0)
    wait = Trajectory(np.array([0.0, rng.uniform(5.0, 40.0)]), still, np.zeros_like(still))
    opening = next((s.opening for s in plan.actions[where[0]].steps if isinstance(s, Release)), move.opening)
    rest = Move("retreat", wait, opening)
    return task, put(plan, where, rest, step_at(plan, where))


def another_falls(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    where = choose(steps_of(plan, Fall), rng)
    if where is None:
        return None
    others = [o.name for o in task.objects if o.name != step_at(plan, where).object]
    name = choose(others or ["nobody"], rng)
    return task, put(plan, where, replace(step_at(plan, where), object=name))


def gives_way_by_itself(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What nothing has touched is said to have come down a little aside."""
    handled, options = set[str](), list[tuple[int, str]]()
    for index, action in enumerate(plan.actions):
        handled.update(action.arguments[:1])
        options += [(index, name) for name in sorted(plan.start.keys() - handled)]
    if not options:
        return None
    index, name = choose(options, rng)
    action, pose = plan.actions[index], shifted(plan.start[name], sideways(rng, 0.003, 0.015))
    return task, put_action(plan, index, replace(action, steps=(*action.steps, Fall(name, pose))))


def fall_upside_down(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """It turns over in its fall."""
    where = choose(steps_of(plan, Fall), rng)
    if where is None:
        return None
    fall = step_at(plan, where)
    over = Pose.from_rpy((0.0, 0.0, 0.0), (np.pi, 0.0, rng.uniform(-np.pi, np.pi)))
    x, y, z = fall.pose.xyz
    turned = over @ Pose((0.0, 0.0, 0.0), fall.pose.quat)
    return task, put(plan, where, replace(fall, pose=Pose((x, y, z), turned.quat)))


def _fallen(task: Task, plan: Plan, rng: np.random.Generator, by: np.ndarray) -> Pair | None:
    """A fall that ends elsewhere than it does."""
    where = choose(steps_of(plan, Fall), rng)
    if where is None:
        return None
    fall = step_at(plan, where)
    return task, put(plan, where, replace(fall, pose=shifted(fall.pose, by)))
