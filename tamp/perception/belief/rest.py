"""Estimates settled in physics: nothing floats, and nothing is inside another thing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from tamp.execution.monitor import angle_between
from tamp.execution.settling.settle import settle
from tamp.execution.simulators import DEFAULT
from tamp.perception.estimate import Estimate
from tamp.task import Pose, Task
from tamp.world.world import World

FAR, TURNED = 0.03, 0.5
"""An estimate that moves or turns more than this while settling contradicts the others [m], [rad]."""

SURE = 0.5
"""One of less confidence that does so is given up."""

LOWEST = -0.02
"""What comes to rest lower has fallen off the table [m]."""

TOUCHING = 0.001
"""Less deep in each other bodies touch [m]."""

HIGHER = 0.002
"""Steps in which a body is raised out of those below it [m]."""


def at_rest(
    task: Task,
    world: World,
    estimates: Mapping[str, Estimate],
    simulator: str = DEFAULT,
    expected: Mapping[str, Pose] = MappingProxyType({}),
) -> dict[str, Estimate]:
    """The estimates as the objects come to rest where they are said to be.

    Estimates that cannot be, and that are not sure, are given up one after the other, the least sure first.

    Args:
        task: objects and table; its own poses are not looked at.
        world: the objects' geometry.
        estimates: object -> estimate.
        simulator: in which it settles.
        expected: object -> where a plan has brought it, or where it stood before; known objects at rest.
    """
    kept = dict(estimates)
    while True:
        poses = {name: e.pose for name, e in kept.items() if e.pose is not None}
        settled = _settled(task, world, poses, expected, simulator) if poses else {}
        doubtful = [name for name in poses if kept[name].confidence < SURE and _strays(poses[name], settled[name])]
        if not doubtful:
            break
        kept[min(doubtful, key=lambda name: (kept[name].confidence, name))] = Estimate(None, 0.0)
    return {
        name: Estimate(None, 0.0)
        if name in settled and _height(world, name, settled[name]) < LOWEST
        else replace(e, pose=settled.get(name))
        for name, e in kept.items()
    }


def _settled(
    task: Task, world: World, poses: Mapping[str, Pose], expected: Mapping[str, Pose], simulator: str
) -> Mapping[str, Pose]:
    """Where everything comes to rest from where it strays least: as it is, raised out of what it is in, as expected.

    Physics throws apart what is in each other. What stands side by side it parts well; what is stacked or nested it
    does not, and estimates of such things are off by as much as their walls are thick. Where they were expected near
    by, they were expected clear of each other.
    """
    best = settle(task, poses, simulator=simulator).poses
    starts: tuple[Callable[[], Mapping[str, Pose]], ...] = (
        lambda: lifted_apart(world, poses),
        lambda: _as_expected(poses, expected),
    )
    for start in starts:
        if _straying(poses, best):
            other = settle(task, start(), simulator=simulator).poses
            best = other if _straying(poses, other) < _straying(poses, best) else best
    return best


def _as_expected(poses: Mapping[str, Pose], expected: Mapping[str, Pose]) -> dict[str, Pose]:
    """The scene with everything where it was expected that is seen near there."""
    return {
        name: expected[name] if name in expected and not _strays(pose, expected[name]) else pose
        for name, pose in poses.items()
    }


def lifted_apart(world: World, poses: Mapping[str, Pose]) -> dict[str, Pose]:
    """The same scene with each object raised until it is in none of those below it, by `FAR` at most.

    Args:
        world: the objects' geometry.
        poses: object -> pose (world frame).
    """
    free: dict[str, Pose] = {}
    for name in sorted(poses, key=lambda name: (_height(world, name, poses[name]), name)):
        free[name] = poses[name]
        for step in range(round(FAR / HIGHER) + 1):
            x, y, z = poses[name].xyz
            higher = Pose((x, y, z + step * HIGHER), poses[name].quat)
            if not any(
                world.overlap(name, higher.matrix, other, pose.matrix, tolerance=TOUCHING)
                for other, pose in free.items()
                if other != name
            ):
                free[name] = higher
                break
    return free


def _height(world: World, name: str, pose: Pose) -> float:
    """Of a body's centre of mass over the table [m]."""
    return float((pose.matrix[:3, :3] @ world.geometries[name].center_of_mass)[2] + pose.xyz[2])


def _straying(poses: Mapping[str, Pose], rest: Mapping[str, Pose]) -> int:
    return sum(_strays(pose, rest[name]) for name, pose in poses.items())


def _strays(pose: Pose, rest: Pose) -> bool:
    return math.dist(pose.xyz, rest.xyz) > FAR or angle_between(pose, rest) > TURNED
