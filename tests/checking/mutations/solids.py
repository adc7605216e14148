"""Corruptions that bring bodies with them which no primitive shape is: rings, and half rounds."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from tamp.task import Box, Grip, Mesh, Object, Plan, Pose, Task
from tamp.task.mesh.parts import Part, convex_hull
from tests.checking.mutations.editing import Pair, added, choose, step_at, steps_of
from tests.task.meshes import parts_obj

CORNER = (-0.25, 0.55)  # of the table, where nothing else is [m]


@lru_cache(maxsize=1)
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="mutants-"))


def _written(name: str, text: str) -> Mesh:
    path = _folder() / f"{name}.obj"
    path.write_text(text, encoding="utf-8")
    return Mesh(path)


def half_round(radius: float, length: float, up: bool) -> Mesh:
    """Half of a rod along x, its round side up or down, and its flat side through the origin."""
    angles = np.linspace(0.0, np.pi, 61)
    arc = radius * np.stack([-np.cos(angles), (1.0 if up else -1.0) * np.sin(angles)], axis=1)
    hull = convex_hull(np.array([(x, *point) for x in (-length / 2, length / 2) for point in arc]))
    return hulls(f"half_{radius:.5f}_{length:.5f}_{up}", [hull])


def hulls(name: str, pieces: Sequence[Part]) -> Mesh:
    """A mesh of convex pieces, in a file of that name."""
    lines, before = list[str](), 0
    for number, hull in enumerate(pieces):
        lines += [f"o part{number}", *(f"v {x} {y} {z}" for x, y, z in hull.vertices)]
        lines += [f"f {a} {b} {c}" for a, b, c in hull.faces + 1 + before]
        before += len(hull.vertices)
    return _written(name, "\n".join(lines) + "\n")


def ring(inner: tuple[float, float], wall: float, height: float) -> Mesh:
    """Four walls round a rectangle, standing at the origin."""
    (x, y), (X, Y) = (side / 2 for side in inner), (side / 2 + wall for side in inner)
    walls = [
        ((x, -Y, 0.0), (X, Y, height)),
        ((-X, -Y, 0.0), (-x, Y, height)),
        ((-x, -Y, 0.0), (x, -y, height)),
        ((-x, y, 0.0), (x, Y, height)),
    ]
    return _written(f"ring_{x:.5f}_{y:.5f}_{wall:.5f}", parts_obj(walls))


def rocking_load(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Out of the way a half round on its back carries too high a load, or one with a plank on it a load to one side."""
    radius, length = rng.uniform(0.04, 0.06), 0.1
    yaw, on_its_back = Pose.from_rpy((*CORNER, 0.0), (0.0, 0.0, rng.uniform(-np.pi, np.pi))), rng.random() < 0.5
    if on_its_back:
        high = rng.uniform(2.0, 2.5) * radius
        things = [
            Object("half", half_round(radius, length, up=False), yaw @ Pose((0.0, 0.0, radius)), mass=0.3),
            Object("load", Box((0.05, 1.6 * radius, high)), yaw @ Pose((0.0, 0.0, radius + high / 2)), mass=0.6),
        ]
    else:
        aside = rng.uniform(0.012, 0.016)
        things = [
            Object("half", half_round(radius, length, up=True), yaw, mass=1.0),
            Object("plank", Box((0.05, 0.2, 0.01)), yaw @ Pose((0.0, 0.0, radius + 0.005)), mass=0.05),
            Object("load", Box((0.04, 0.04, 0.06)), yaw @ Pose((0.0, aside, radius + 0.04)), mass=0.6),
        ]
    for thing in things:
        task, plan = added(task, plan, thing)
    return task, plan


def wedged_in(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """Round the foot of a box that is lifted there is a ring, which is a little too narrow for it."""
    standing = [
        where
        for where in steps_of(plan, Grip)
        for thing in [task.object(step_at(plan, where).attachment.object)]
        if isinstance(thing.shape, Box)
        and plan.start[thing.name].matrix[2, 2] > 0.999
        and abs(plan.start[thing.name].xyz[2] - thing.shape.size[2] / 2) < 1e-3
    ]
    if (where := choose(standing[:1], rng)) is None:
        return None
    thing = task.object(step_at(plan, where).attachment.object)
    narrow = 2 * rng.uniform(0.0005, 0.0015)
    around = ring((thing.shape.size[0] - narrow, thing.shape.size[1] - narrow), 0.006, 0.01)
    x, y, _ = thing.pose.xyz
    return added(task, plan, Object("ring", around, replace(thing.pose, xyz=(x, y, 0.0)), mass=0.05))
