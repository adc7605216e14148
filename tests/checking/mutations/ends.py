"""Corruptions of a plan's two ends: the scene it starts from, and the goals it should reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.checking.robot.kinematics import read_kinematics
from tamp.task import At, Box, Object, Plan, Pose, Task, load_robot
from tests.checking.mutations.editing import Pair, added, changed, choose, shifted, sideways


def stale_start(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The scene has changed since the plan was made."""
    name = choose(sorted(plan.start), rng)
    pose = shifted(plan.start[name], sideways(rng, 0.04, 0.2))
    return task, replace(plan, start={**plan.start, name: pose})


def start_in_the_air(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    name = choose(sorted(plan.start), rng)
    pose = shifted(plan.start[name], np.array([0.0, 0.0, rng.uniform(0.01, 0.1)]))
    return task, replace(plan, start={**plan.start, name: pose})


def start_at_goals(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Nothing is done: everything is said to stand at its goal from the beginning."""
    far = [n for n, goal in plan.goals.items() if np.linalg.norm(np.subtract(goal.xyz, plan.start[n].xyz)) > 0.06]
    return (task, replace(plan, start={**plan.start, **plan.goals}, actions=())) if far else None


def one_in_the_air_frees_another(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """One object is written above where it starts; another is said to start elsewhere than it is written."""
    if len(task.objects) < 2:
        return None
    loose, freed = (task.objects[i].name for i in rng.permutation(len(task.objects))[:2])
    up = shifted(task.object(loose).pose, np.array([0.0, 0.0, rng.uniform(0.03, 0.1)]))
    pose = shifted(plan.start[freed], sideways(rng, 0.06, 0.2))
    return changed(task, loose, pose=up), replace(plan, start={**plan.start, freed: pose})


def other_home(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    home = list(plan.home)
    home[int(rng.integers(len(home)))] += rng.choice([-1, 1]) * rng.uniform(0.01, 0.3)
    return task, replace(plan, home=tuple(home))


def goal_missed(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The task asks for something else than the plan does."""
    name = choose([o.name for o in task.objects if isinstance(o.goal, At)], rng)
    if name is None:
        return None
    goal = At(shifted(task.object(name).goal.pose, sideways(rng, 0.035, 0.3)))
    return changed(task, name, goal=goal), plan


def start_in_the_robot(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A post stands where the hand is at home."""
    x, y, z = read_kinematics(load_robot(task.robot)).tool(np.array([plan.home]))[0, :3, 3]
    height, wide = float(z + rng.uniform(0.02, 0.06)), float(rng.uniform(0.06, 0.1))
    return added(task, plan, Object("post", Box((wide, wide, height)), Pose((float(x), float(y), height / 2))))
