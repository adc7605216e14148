"""Scenes to be labelled: some of many objects, dropped on to the table in any orientation and let settle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tamp.execution.settling.settle import settle
from tamp.execution.simulators import DEFAULT
from tamp.task import Object, Pose, Table, Task
from tamp.task.mesh.parts import bounds

SPREAD = 0.62
"""Share of the table's length and width that objects are dropped over: some come to lie on each other."""

UPRIGHT = 0.5
"""Share of objects that are dropped as their frames stand; the others in any orientation."""

GAP = 0.01
"""Between what is dropped and what is dropped before it [m]."""

LAYER = 3
"""So many objects at a time are dropped from over each other."""

EDGE = 0.02
"""What lies nearer to the table's edge than this, or beyond, has fallen off [m]."""


def random_scene(
    objects: Sequence[Object], count: int, table: Table, rng: np.random.Generator, simulator: str = DEFAULT
) -> dict[str, Pose]:
    """Object -> pose (world frame) at rest, of those that stay on the table.

    Args:
        objects: what there is to choose from.
        count: how many are dropped.
        table: the table top.
        rng: source of every random choice.
        simulator: in which they settle.
    """
    chosen = [objects[i] for i in rng.permutation(len(objects))[:count]]
    height, dropped = 0.0, []
    for obj in chosen:
        lower, upper = bounds(obj.shape)
        radius = float(np.linalg.norm(np.maximum(np.abs(lower), np.abs(upper))))
        x, y = np.array(table.center) + SPREAD / 2 * np.array(table.size) * rng.uniform(-1.0, 1.0, 2)
        upright = rng.random() < UPRIGHT
        quat = _yawed(rng) if upright else _any(rng)
        z = height + GAP + (-float(lower[2]) if upright else radius)
        dropped.append(replace(obj, pose=Pose((float(x), float(y), z), quat), goal=None))
        height = z + (float(upper[2]) if upright else radius) if len(dropped) % LAYER else 0.0
    resting = settle(Task("scene", tuple(dropped), table=table), simulator=simulator).poses
    return {name: pose for name, pose in resting.items() if _stays(pose, table)}


def _yawed(rng: np.random.Generator) -> tuple[float, float, float, float]:
    half = rng.uniform(0.0, np.pi)
    return (0.0, 0.0, float(np.sin(half)), float(np.cos(half)))


def _any(rng: np.random.Generator) -> tuple[float, float, float, float]:
    x, y, z, w = rng.normal(size=4)
    return (float(x), float(y), float(z), float(w))


def _stays(pose: Pose, table: Table) -> bool:
    x, y, z = pose.xyz
    inside = all(abs(v - c) < s / 2 - EDGE for v, c, s in zip((x, y), table.center, table.size, strict=True))
    return inside and z > -EDGE
