"""Corruptions of stacks: masses with which they tip, bodies that are in each other, stand tilted, or tip over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Box, Cylinder, Object, Plan, Pose, Sphere, Task
from tests.checking.mutations.editing import Pair, changed, choose

LIGHT, HEAVY = 0.05, 6.0
CORNER = (-0.25, 0.55)  # of the table, where nothing else is [m]


def light_counterweight(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What holds a plank down weighs next to nothing, and what stands on its ends does not balance."""
    if not any(o.name == "plank" for o in task.objects):
        return None
    return changed(task, "ballast", mass=rng.uniform(LIGHT / 2, LIGHT)), plan


def heavy_load(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What is taken from one end of a plank, or put on the other, or stays there, outweighs all the rest."""
    name = choose([o.name for o in task.objects if o.name in ("red", "green", "blue")], rng)
    if name is None or not any(o.name == "plank" for o in task.objects):
        return None
    return changed(task, name, mass=rng.uniform(HEAVY, 1.2 * HEAVY)), plan


def sunk_tower(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A tower out of the way, whose slabs are each a little in the one below: the topmost is far too low."""
    deep, count, (x, y) = rng.uniform(0.0013, 0.0018), int(rng.integers(6, 9)), CORNER
    places = (Pose((x, y, 0.01 - deep + i * (0.02 - deep))) for i in range(count))
    slabs = [Object(f"slab {i}", Box((0.05, 0.05, 0.02)), place) for i, place in enumerate(places)]
    start = {**plan.start, **{slab.name: slab.pose for slab in slabs}}
    return replace(task, objects=(*task.objects, *slabs)), replace(plan, start=start)


def stands_tilted(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A box out of the way stands on its edge, its other side a little above the table."""
    wide, tilt, yaw = rng.uniform(0.02, 0.03), rng.uniform(0.08, 0.1), rng.uniform(-np.pi, np.pi)
    high = rng.uniform(3.0, 4.0) * wide
    up = high / 2 * np.cos(tilt) + wide / 2 * np.sin(tilt)
    pose = Pose.from_rpy((*CORNER, up), (0.0, tilt, yaw))
    box = Object("tilted", Box((wide, 0.05, high)), pose)
    return replace(task, objects=(*task.objects, box)), replace(plan, start={**plan.start, box.name: pose})


def falls_the_other_way(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A stick out of the way leans beyond its balance, and is said to lie on the other side of its edge."""
    return _lies(task, plan, rng, rng.uniform(0.3, 0.9), -1)


def falls_though_in_balance(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A stick out of the way leans a little, would stand up, and is said to lie."""
    return _lies(task, plan, rng, rng.uniform(0.02, 0.06), int(rng.choice([-1, 1])))


def _lies(task: Task, plan: Plan, rng: np.random.Generator, lean: float, side: int) -> Pair:
    """A stick that leans to the right on its edge, and is said to lie on one side of that."""
    wide, high = rng.uniform(0.03, 0.035), rng.uniform(0.16, 0.2)
    edge = Pose.from_rpy((*CORNER, 0.0), (0.0, 0.0, rng.uniform(-np.pi, np.pi)))
    leans = edge @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, lean, 0.0)) @ Pose((-wide / 2, 0.0, high / 2))
    lies = edge @ Pose.from_rpy((side * high / 2, 0.0, wide / 2), (0.0, side * np.pi / 2, 0.0))
    stick = Object("stick", Box((wide, 0.05, high)), leans)
    task = replace(task, objects=(*task.objects, stick))
    return task, replace(plan, start={**plan.start, stick.name: lies})


def rolls_down_a_slope(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A ball, or a can, out of the way lies on a plank that slopes by a degree or two, one end of it on a card."""
    slope, along, radius = rng.uniform(0.015, 0.035), rng.uniform(0.05, 0.1), rng.uniform(0.015, 0.03)
    foot = Pose.from_rpy((*CORNER, 0.0), (0.0, 0.0, rng.uniform(-np.pi, np.pi)))
    rises = foot @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -slope, 0.0))
    card = foot @ Pose((0.12 * np.cos(slope) + 0.02, 0.0, 0.06 * np.sin(slope)))
    lying = bool(rng.integers(2))
    round_thing = Cylinder(radius, 0.05) if lying else Sphere(radius)
    turn = Pose.from_rpy((along, 0.0, 0.01 + radius), (np.pi / 2 if lying else 0.0, 0.0, 0.0))
    return _with(
        task,
        plan,
        Object("card", Box((0.04, 0.06, 0.12 * np.sin(slope))), card),
        Object("slope", Box((0.16, 0.06, 0.01)), rises @ Pose((0.08, 0.0, 0.005)), mass=0.2),
        Object("round", round_thing, rises @ turn, mass=0.1),
    )


def rolls_off_what_is_light(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A ball out of the way lies on a box that weighs a thirtieth of it, or less, near the edge of that."""
    place, aside = Pose((*CORNER, 0.0)), rng.uniform(0.01, 0.02)
    return _with(
        task,
        plan,
        Object("light", Box((0.05, 0.05, 0.05)), place @ Pose((0.0, 0.0, 0.025)), mass=0.03),
        Object("round", Sphere(0.03), place @ Pose((aside, 0.0, 0.08)), mass=rng.uniform(0.9, 1.4)),
    )


def starts_beyond_the_rim(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A domino, or a slab, out of the way stands on a block, its middle by less than a millimetre beyond the rim."""
    place, beyond = Pose((*CORNER, 0.0)), rng.uniform(2e-4, 8e-4)
    long, high = ((0.012, 0.1), (0.06, 0.02))[int(rng.integers(2))]
    return _with(
        task,
        plan,
        Object("ledge", Box((0.1, 0.1, 0.05)), place @ Pose((0.0, 0.0, 0.025)), mass=2.0),
        Object("verge", Box((long, 0.05, high)), place @ Pose((0.05 + beyond, 0.0, 0.05 + high / 2)), mass=0.1),
    )


def _with(task: Task, plan: Plan, *things: Object) -> Pair:
    """The same with more objects, which stay where they are."""
    start = {**plan.start, **{thing.name: thing.pose for thing in things}}
    return replace(task, objects=(*task.objects, *things)), replace(plan, start=start)
