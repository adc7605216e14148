"""What is clearly wrong with an object that was let go and falls."""

from __future__ import annotations

import numpy as np

from tamp.task import Fall
from tests.checking.oracle.bodies import depth
from tests.checking.oracle.world import TOUCHING, World, rests, stands_flat

RISES = 0.01  # a centre that comes to rest so much higher has not fallen [m]
SLIDES = 0.02  # the part that was lowest, or the centre, goes no further than this along the ground [m]
CLEARLY = 1.5  # so many times the energy that it takes to tip over is too much
ROCKS = 0.05  # share of what a fall keeps as it rocks that lifts it over another edge of its foot
TURNED = 0.05  # what turns less comes straight down [rad]
STAYS = 0.001  # what is said to come no farther may not have moved [m]
LOW = 5e-4  # what is no higher stands on the table [m]
FALLEN, TOPPLED = 1.3, 1.8  # what falls flat, or is pushed over, turns no further [rad]


def fall(world: World, fall: Fall, turns: float) -> str | None:
    """The object rests where the plan says; why it cannot have fallen there, or None."""
    name, before, after = fall.object, world.poses[fall.object], fall.pose.matrix
    body = world.bodies[name]
    ends = [body.points @ T[:3, :3].T + T[:3, 3] for T in (before, after)]
    world.poses[name] = after
    if ends[1].mean(axis=0)[2] > ends[0].mean(axis=0)[2] + RISES:
        return f"{name} falls up"
    lowest = ends[0][:, 2] < ends[0][:, 2].min() + 0.002
    if np.arccos(np.clip((np.trace(before[:3, :3].T @ after[:3, :3]) - 1) / 2, -1.0, 1.0)) > turns:
        return f"{name} turns over"
    moved = (ends[1] - ends[0])[:, :2]
    if min(np.linalg.norm(moved[lowest], axis=1).min(), np.linalg.norm(moved.mean(axis=0))) > SLIDES:
        return f"{name} falls sideways"
    for other, T in world.others(name).items():
        if depth(body, after, world.bodies[other], T) > TOUCHING:
            return f"{name} falls into {other}"
    return rests(world, name) or tips_on(world, name, before, after) or rocks(world, name, before, after)


def gave_way(world: World, fall: Fall) -> str | None:
    """Something that the plan does not handle comes down a little; why it clearly does not, or None."""
    name, before, after = fall.object, world.poses.get(fall.object), fall.pose.matrix
    if before is None:
        return f"there is no {name}"
    ends = [world.bodies[name].points @ T[:3, :3].T + T[:3, 3] for T in (before, after)]
    moved, alone = np.linalg.norm(ends[1] - ends[0], axis=1).mean(), stands_flat(world, name)
    world.poses[name] = after
    if ends[1].mean(axis=0)[2] > ends[0].mean(axis=0)[2] + RISES or moved > SLIDES:
        return f"{name} goes where nothing takes it"
    return f"{name} stands flat and alone, and does not give way" if alone and moved > STAYS else None


def tips_on(world: World, name: str, before: np.ndarray, after: np.ndarray) -> str | None:
    """Why a body that has turned over onto the table does not stop there, or None.

    A cloud of equal masses stands for it, in whose plane of motion the first point over the table's edge is struck.
    """
    R = after[:3, :3] @ before[:3, :3].T
    turn = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], 0.0])
    if np.linalg.norm(turn) < 0.5:
        return None
    body, table = world.bodies[name].points, world.task.table
    starts, ends = (body @ T[:3, :3].T + T[:3, 3] for T in (before, after))
    axis = turn / np.linalg.norm(turn)
    pivot = ends[np.linalg.norm(ends - starts, axis=1).argmin()]
    drop = float(starts[:, 2].mean() - ends[:, 2].mean())
    speeds = np.cross(axis, ends - pivot)
    speeds *= np.sqrt(2 * 9.81 * max(drop, 0.0) / (speeds**2).sum(axis=1).mean())
    for way in np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]):
        line = float(way[:2] @ table.center + np.abs(way[:2]) @ table.size / 2)
        over, arms = np.cross((0.0, 0.0, 1.0), way), ends - line * way
        arms[:, 2] = ends[:, 2]
        inside, high = -float((arms @ way).mean()), float(arms[:, 2].mean())
        arms -= np.outer(arms @ over, over)
        kept = float((np.cross(arms, speeds) @ over).mean())
        energy = max(kept, 0.0) ** 2 / (arms**2).sum(axis=1).mean() / 2
        if (arms @ way).max() > 0.0 and energy > CLEARLY * 9.81 * (np.hypot(max(inside, 0.0), high) - high):
            return f"{name} tips on over the edge of the table"
    return None


def rocks(world: World, name: str, before: np.ndarray, after: np.ndarray) -> str | None:
    """Why a body that has turned over onto the table does not stop on its foot there, or None.

    A cloud of equal masses stands for it, which comes down about one edge of the foot and goes on about another one.
    """
    if np.arccos(np.clip((np.trace(before[:3, :3].T @ after[:3, :3]) - 1) / 2, -1.0, 1.0)) < TURNED:
        return None
    starts, ends = (world.bodies[name].points @ T[:3, :3].T + T[:3, 3] for T in (before, after))
    drop, foot = float(starts[:, 2].mean() - ends[:, 2].mean()), ends[np.abs(ends[:, 2]) < LOW]
    others = world.others(name, "table").items()
    if len(foot) < 3 or any(depth(world.bodies[name], after, world.bodies[o], T) > -0.002 for o, T in others):
        return None
    for angle in np.linspace(0.0, 2 * np.pi, 36, endpoint=False):
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        over, along = np.cross((0.0, 0.0, 1.0), way), foot @ way
        came, goes = (
            ends - foot[end] - np.outer((ends - foot[end]) @ over, over) for end in (along.argmin(), along.argmax())
        )
        speeds = np.cross(over, came)
        speeds *= np.sqrt(2 * 9.81 * max(drop, 0.0) / (speeds**2).sum(axis=1).mean())
        kept = float((np.cross(goes, speeds) @ over).mean()) ** 2 / (goes**2).sum(axis=1).mean() / 2
        if ROCKS * kept > 9.81 * _rises(ends, way):
            return f"{name} rocks over the edge of its foot"
    return None


def _rises(points: np.ndarray, way: np.ndarray) -> float:
    """How high the middle of a cloud of points is lifted, as it rolls some way over its hull, before it sinks [m]."""
    arms, rise = points - points.mean(axis=0), 0.0
    x, z = arms @ way, arms[:, 2]
    stood = last = -float(z.min())
    for turned in np.radians(np.arange(0.1, 90.0, 0.1)):
        high = -float((np.cos(turned) * z - np.sin(turned) * x).min())
        if high < last:
            break
        last = high
        rise = high - stood
    return rise
