"""Corruptions of the masses in a stack, so that it tips where the plan takes something off it or puts something on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Plan, Task
from tests.checking.mutations.editing import Pair, choose

LIGHT, HEAVY = 0.05, 6.0


def light_counterweight(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What holds a plank down weighs next to nothing, and what stands on its ends does not balance."""
    if not any(o.name == "plank" for o in task.objects):
        return None
    return weighing(task, "ballast", rng.uniform(LIGHT / 2, LIGHT)), plan


def heavy_load(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What is taken from one end of a plank, or put on the other, or stays there, outweighs all the rest."""
    name = choose([o.name for o in task.objects if o.name in ("red", "green", "blue")], rng)
    if name is None or not any(o.name == "plank" for o in task.objects):
        return None
    return weighing(task, name, rng.uniform(HEAVY, 1.2 * HEAVY)), plan


def weighing(task: Task, name: str, mass: float) -> Task:
    """The task with another mass of an object [kg]."""
    return replace(task, objects=tuple(replace(o, mass=mass) if o.name == name else o for o in task.objects))
