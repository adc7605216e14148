"""Scenes whose poses were rounded: what rests as it was meant may overlap then, or stand just over an edge.

Physics throws out what begins deep in another body, and lets fall what lost its balance by a millimetre. Where a scene
ends far from where it was given, it is let settle again from places within the rounding, and the nearest rest counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.monitor import angle_between
from tamp.execution.settling.settle import Settled, settle
from tamp.execution.simulators import DEFAULT
from tamp.task import Object, Pose, Task
from tamp.world.geometry.convex_union import Solid, overlap, relative, solid
from tamp.world.geometry.object_geometry import geometry_of_object

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DEEP = 0.002
"""So deep bodies may be in each other: contact explains it [m]."""
FAR, STEP = 0.012, 0.001
"""How far one is moved at most, and in what steps: two poses rounded to a centimetre are up to 1 cm off up [m]."""
WAYS = ((0.0, 0.0, 1.0), *((np.cos(a), np.sin(a), 0.0) for a in np.linspace(0.0, 2 * np.pi, 8, endpoint=False)))
"""Up, and to the sides."""
AIM = 0.02
"""What settles farther aside than this, or turns over, may have been thrown or have fallen [m]."""
LEVER = 0.05
"""What a turn counts [m/rad]: about half the size of what stands on tables."""
ROUNDED = 0.005
"""How far rounding to a centimetre moves anything, along each axis [m]."""
DRAWS, TRIED_S = 6, 3.0
"""Scenes within the rounding that are let settle beside the parted one, and for how long each [simulated s]."""


def nearest_rest(
    task: Task, poses: Mapping[str, Pose], *, deadline: float = math.inf, simulator: str = DEFAULT
) -> Settled:
    """Where objects come to rest, nearest to where they are given, from any place within the rounding of their poses.

    The scene as it is given comes first, and is the answer where nothing goes far aside. The draws are the same for
    every scene.

    Args:
        task: objects and table.
        poses: object -> pose (world frame); an object absent here stays out of the scene.
        deadline: on the clock of tamp.clock.now() [s].
        simulator: its name, or "package.module:Class".

    Raises:
        TampError, TaskError, PlanningFailure: as `settle`.
    """
    best = settle(task, poses, deadline=deadline, simulator=simulator)
    for tried in _within_rounding(task, poses):
        if _worst(best, poses) <= AIM:
            break
        rest = settle(task, tried, limit_s=TRIED_S, deadline=deadline, simulator=simulator)
        best = min(best, rest, key=lambda found: sum(_astray(found, poses)))
    return replace(best, moved={name: math.dist(pose.xyz, poses[name].xyz) for name, pose in best.poses.items()})


def _worst(rest: Settled, poses: Mapping[str, Pose]) -> float:
    return max(_astray(rest, poses), default=0.0)


def _astray(rest: Settled, poses: Mapping[str, Pose]) -> list[float]:
    """How far each object went aside and turned [m]; infinite where some still move. Straight down is no matter."""
    return [
        math.dist(pose.xyz[:2], poses[name].xyz[:2]) + LEVER * angle_between(pose, poses[name])
        if rest.resting
        else math.inf
        for name, pose in rest.poses.items()
    ]


def _within_rounding(task: Task, poses: Mapping[str, Pose]) -> Iterator[dict[str, Pose]]:
    """The poses with what overlaps parted, and some that would be rounded to them; what is written finer stays."""
    yield parted(task.objects, poses)
    rounded, rng = [name for name, pose in poses.items() if _is_rounded(pose)], np.random.default_rng(0)
    for _ in range(DRAWS if rounded else 0):
        moves = rng.uniform(-ROUNDED, ROUNDED, (len(rounded), 3)).tolist()
        yield {**poses, **{name: _shifted(poses[name], *move) for name, move in zip(rounded, moves, strict=True)}}


def _is_rounded(pose: Pose) -> bool:
    """Whether a position is in whole centimetres."""
    return all(abs(100 * value - round(100 * value)) < 1e-6 for value in pose.xyz)


def _shifted(pose: Pose, dx: float, dy: float, dz: float) -> Pose:
    x, y, z = pose.xyz
    return replace(pose, xyz=(x + dx, y + dy, z + dz))


def parted(objects: Iterable[Object], poses: Mapping[str, Pose]) -> dict[str, Pose]:
    """The poses, each of what is deep in something lower moved by as little as takes it out, and at most 12 mm.

    Args:
        objects: the bodies; one without a pose is left out.
        poses: object -> pose (world frame).

    Raises:
        TaskError: where an object's mesh cannot be used.
    """
    bodies = {item.name: geometry_of_object(item) for item in objects if item.name in poses}
    low = {n: float((g.hull.vertices @ poses[n].matrix[2, :3]).min()) + poses[n].xyz[2] for n, g in bodies.items()}
    solids = {name: solid(geometry.parts) for name, geometry in bodies.items()}
    placed: dict[str, Array] = {}
    for name in sorted(bodies, key=lambda name: (low[name], name)):
        placed[name] = _clear(name, poses[name].matrix, solids, placed)
    return {n: Pose.from_matrix(placed[n]) if n in placed and _moved(placed[n], p) else p for n, p in poses.items()}


def _clear(name: str, T: Array, solids: Mapping[str, Solid], placed: Mapping[str, Array]) -> Array:
    """The nearest place that is clear of what is placed; T itself where there is none."""
    if not _deep(name, T, solids, placed):
        return T
    for far in np.arange(STEP, FAR + STEP / 2, STEP):
        for way in WAYS:
            moved = T.copy()
            moved[:3, 3] += far * np.array(way)
            if not _deep(name, moved, solids, placed):
                return moved
    return T


def _deep(name: str, T: Array, solids: Mapping[str, Solid], placed: Mapping[str, Array]) -> bool:
    return any(overlap(solids[name], solids[other], relative(T, at), -DEEP) for other, at in placed.items())


def _moved(T: Array, pose: Pose) -> bool:
    return bool((T[:3, 3] != pose.matrix[:3, 3]).any())
