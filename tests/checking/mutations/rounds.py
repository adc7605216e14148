"""Corruptions that bring balls with them, which lie where they do not stay, or where nothing takes them.

In a groove that slopes, on half a rim, across a gap; aside of where they come down on the level table.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.task import Box, Mesh, Object, Plan, Pose, Sphere, Task
from tamp.task.mesh.parts import convex_hull
from tests.checking.mutations.editing import Pair, added
from tests.checking.mutations.solids import CORNER, hulls

POST = Box((0.015, 0.015, 0.06))


def rolls_along_a_groove(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A ball out of the way lies in a groove, which holds it on both sides and slopes along itself."""
    slope, lean, radius = rng.uniform(0.04, 0.12), rng.uniform(0.3, 0.9), rng.uniform(0.015, 0.025)
    low = Pose.from_rpy((*CORNER, 0.0), (0.0, 0.0, rng.uniform(-np.pi, np.pi)))
    middle = Pose((0.0, 0.0, 0.03)) @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -slope, 0.0))
    ball = Object("ball", Sphere(radius), low @ middle @ Pose((0.0, 0.0, radius / np.cos(lean))), mass=0.1)
    trough = Object("trough", groove(slope, lean), low, mass=1.0)
    return added(*added(task, plan, trough), ball)


def groove(slope: float, lean: float) -> Mesh:
    """Two flanks of a groove along x, whose bottom is 3 cm high in the middle and slopes, as their faces lean [rad]."""
    halves = []
    for side in (-1.0, 1.0):
        ends = [(x, 0.03 + x * np.tan(slope)) for x in (-0.08, 0.08)]
        top = [(x, side * y, z + y * np.tan(lean) / np.cos(slope)) for x, z in ends for y in (0.0, 0.04)]
        halves.append(convex_hull(np.array([*top, *((x, y, 0.0) for x, y, _ in top)])))
    return hulls(f"groove_{slope:.5f}_{lean:.5f}", halves)


def lies_across_a_gap(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A ball out of the way lies between two light blocks that little friction keeps from sliding apart."""
    radius, friction, wide = rng.uniform(0.018, 0.025), rng.uniform(0.15, 0.3), 0.03
    half, high = rng.uniform(0.75, 0.88) * radius, 1.3 * radius
    between = Pose.from_rpy((*CORNER, 0.0), (0.0, 0.0, np.pi / 2 + rng.uniform(-0.3, 0.3)))
    for side in (-1, 1):
        at = between @ Pose((0.0, side * (half + wide / 2), high / 2))
        block = Object(f"block{side}", Box((0.06, wide, high)), at, mass=0.1, friction=friction)
        task, plan = added(task, plan, block)
    at = between @ Pose((0.0, 0.0, high + float(np.sqrt(radius**2 - half**2))))
    return added(task, plan, Object("ball", Sphere(radius), at, mass=0.4, friction=friction))


def rolls_off_half_a_rim(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A ball out of the way lies on the inner edges of three posts that stand on one side of it."""
    radius, away, between = 0.025, rng.uniform(0.008, 0.014), rng.uniform(1.2, 1.4)
    round_it = Pose.from_rpy((*CORNER, 0.0), (0.0, 0.0, rng.uniform(-np.pi, np.pi)))
    high = POST.size[2] + float(np.sqrt(radius**2 - away**2))
    task, plan = added(task, plan, Object("ball", Sphere(radius), round_it @ Pose((0.0, 0.0, high)), mass=0.1))
    for k in range(3):
        side = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, (k - 1) * between))
        post = round_it @ side @ Pose((away + POST.size[0] / 2, 0.0, POST.size[2] / 2))
        task, plan = added(task, plan, Object(f"post {k}", POST, post, mass=0.5))
    return task, plan


def rolls_by_itself(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A ball out of the way is written above the table, and said to start aside, turned as if it had rolled there."""
    radius, up = rng.uniform(0.015, 0.03), rng.uniform(0.012, 0.08)
    turn = rng.uniform(0.03, 0.05) / radius
    task, plan = added(task, plan, Object("ball", Sphere(radius), Pose((*CORNER, radius + up)), mass=0.1))
    there = Pose.from_rpy((CORNER[0] + radius * turn, CORNER[1], radius), (0.0, turn, 0.0))
    return task, replace(plan, start={**plan.start, "ball": there})
