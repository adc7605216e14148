"""What is clearly wrong with an object that was let go and falls."""

from __future__ import annotations

import numpy as np

from tamp.task import Fall
from tests.checking.oracle.bodies import depth
from tests.checking.oracle.world import TOUCHING, World, rests

RISES = 0.01  # a centre that comes to rest so much higher has not fallen [m]
SLIDES = 0.02  # the part that was lowest, or the centre, goes no further than this along the ground [m]
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
    return rests(world, name)
