"""Does what carries a load tip with it? Tilted by brute force until it touches again, is the centre of all lower?"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tests.checking.oracle.bodies import Body, depth, within
from tests.checking.oracle.world import World

TILT = 0.35  # [rad]
LOWER = 0.001  # by which the centre of all is lower where it tips [m]
TOUCHING = 0.002  # what meets another body when it is shifted so far touches it [m]
DRAWN = 6000  # points of the box round a body, of which those inside it say where its centre is
WAYS = 90  # what is long tips about its own axis alone


def tipping(world: World) -> str | None:
    """Which body tips, as it is tilted on the one that carries it, with what touches it besides; or None."""
    names = sorted(world.others("table"))
    for name in names:
        for under in (other for other in (*names, "table") if other != name and _touch(world, name, other, (2,))):
            group = {name}
            while more := {o for o in names if o != under and any(_touch(world, o, g) for g in group - {o})} - group:
                group |= more
            pairs = [(one, other) for one in group for other in {under, "table"} if (one, other) != (name, under)]
            held = any(_touch(world, *pair) for pair in pairs)
            if len(group) > 1 and not held and _lower(world, name, under, group):
                return f"{name} tips on {under} with {', '.join(sorted(group - {name}))}"
    return None


def _touch(world: World, one: str, other: str, axes: tuple[int, ...] = (0, 1, 2)) -> bool:
    """Whether a body meets another where it is shifted a little, downwards alone or any way."""
    for axis in axes:
        for sign in (-1.0, 1.0)[: 1 if axes == (2,) else 2]:
            T = world.poses[one].copy()
            T[axis, 3] += sign * TOUCHING
            if depth(world.bodies[one], T, world.bodies[other], world.poses[other]) > TOUCHING / 4:
                return True
    return False


def _lower(world: World, name: str, under: str, group: set[str]) -> bool:
    body, T = world.bodies[name], world.poses[name]
    carrier, T_under = world.bodies[under], world.poses[under]
    center = _center(world, group)
    level = _height(body, T, carrier, T_under)
    for angle in np.linspace(0.0, 2 * np.pi, WAYS, endpoint=False):
        R = np.eye(4)
        R[:3, :3] = Rotation.from_rotvec(TILT * np.array([np.cos(angle), np.sin(angle), 0.0])).as_matrix()
        about = np.eye(4)
        about[:3, 3] = (*center[:2], T[2, 3])
        turn = about @ R @ np.linalg.inv(about)
        half = about @ _half(R) @ np.linalg.inv(about)
        heights = [
            (turned @ np.append(center, 1.0))[2] + _height(body, turned @ T, carrier, T_under) - level
            for turned in (half, turn)
        ]
        if heights[0] < center[2] and heights[1] < center[2] - LOWER:
            return True
    return False


def _half(R: np.ndarray) -> np.ndarray:
    half = np.eye(4)
    half[:3, :3] = Rotation.from_rotvec(Rotation.from_matrix(R[:3, :3]).as_rotvec() / 2).as_matrix()
    return half


def _height(body: Body, T: np.ndarray, carrier: Body, T_carrier: np.ndarray) -> float:
    """How far a body at T must go up, or may come down, to just touch another [m]."""
    low, high = -0.1, 0.1
    for _ in range(14):
        middle = (low + high) / 2
        raised = T.copy()
        raised[2, 3] += middle
        low, high = (middle, high) if depth(body, raised, carrier, T_carrier) > 0.0 else (low, middle)
    return high


def _center(world: World, group: set[str]) -> np.ndarray:
    """The common centre of mass of some bodies, (3,), by points drawn at random in each."""
    rng, total, moment = np.random.default_rng(0), 0.0, np.zeros(3)
    for name in sorted(group):
        body, T = world.bodies[name], world.poses[name]
        drawn = rng.uniform(*body.box, size=(DRAWN, 3)) @ T[:3, :3].T + T[:3, 3]
        mass = world.task.object(name).mass
        total, moment = total + mass, moment + mass * drawn[within(body, T, drawn)].mean(axis=0)
    return moment / total
