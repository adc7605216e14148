"""Is what the hand lifts, lowers or drops wedged in an object, so that friction takes that along or keeps it out?

What one wall presses on moves a little aside and slides on. Walls of one object on both sides leave no way aside.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance, deeper
from tamp.checking.geometry.transforms import inverse, rotation
from tamp.checking.robot.sweep import Mover, passed, standing, touches

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.geometry.solids import Solid
    from tamp.checking.robot.sweep import Looks
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

PRESSED = 5e-5
"""What is no deeper than this in something slides out of it [m]."""
ROOM = 5e-4
"""What drops needs on all sides: nobody leads it [m]."""
SHARES = (0.2, 0.4)
"""Of a drop, after which it is asked: what it comes down on is not near yet."""
ASIDE = 16
"""Ways in which it is moved aside."""
FARTHER = (1.0, 1.5)
"""So many times as far as it is deep in something."""
TURNS = (0.0, -0.01, 0.01, -0.02, 0.02)
"""And turned about the way that it goes [rad]."""


def wedged(scene: Scene, state: State, phase: str, found: Looks, allow: Tolerances) -> Iterator[str]:
    """Objects that what is held, the last of the bodies of a motion, is wedged in where it has left its rest.

    Args:
        scene: the world.
        state: what is where.
        phase: of the motion: one that lowers ends where the object rests, for others it was gripped there.
        found: the motion.
        allow: tolerances.
    """
    taken = found.bodies[-1]
    lifted = taken.T[0] if state.gripped is None else state.gripped
    resting = (taken.T[-1] if phase == "lower" else lifted)[:3, 3]
    away = np.linalg.norm(taken.T[:, :3, 3] - resting, axis=1) > allow.strayed
    if not away.any():
        return
    going = Mover(taken.solid, np.ascontiguousarray(taken.T[away]))
    for other in passed([going], standing(scene.solids, state.without(taken.solid.name).poses)):
        for touch in touches([(other, going, PRESSED)]):
            T = inverse(other.T[0]) @ going.T[touch.sample]
            way = other.T[0][:3, :3].T @ (going.T[touch.sample, :3, 3] - resting)
            if _stuck(other.solid, taken.solid, T, way / float(np.linalg.norm(way))):
                yield other.solid.name


def jammed(scene: Scene, state: State, name: str, held: Array, allow: Tolerances) -> Iterator[str]:
    """Objects in which an object that now stands would get stuck as it drops from where it was `held`, shape (4, 4)."""
    T = state.poses[name]
    way = T[:3, 3] - held[:3, 3]
    if way[2] > -allow.strayed:
        return
    path = np.tile(T, (len(SHARES), 1, 1))
    path[:, :3, 3] = held[:3, 3] + np.outer(SHARES, way)
    falling = Mover(scene.solids[name], path)
    for other in passed([falling], standing(scene.solids, state.without(name).poses)):
        poses = (inverse(other.T[0]) @ at for at in path)
        if any(_stuck(other.solid, falling.solid, at, -other.T[0][2, :3], ROOM) for at in poses):
            yield other.solid.name


def _stuck(around: Solid, body: Solid, T: Array, way: Array, room: float = -PRESSED) -> bool:
    """Whether a body at T in the frame of another has too little room, wherever it is moved a little aside of its way.

    `way` is a unit vector, shape (3,); where `room` is negative it may be so deep in the other [m].
    """
    short = room - clearance(around, body, T, max(room, 0.0))
    across = np.linalg.svd(way[None])[2][1:]
    angles = np.linspace(0.0, 2 * np.pi, ASIDE, endpoint=False)
    sides = np.stack([np.cos(angles), np.sin(angles)], axis=1) @ across
    middle = T[:3, :3] @ body.center + T[:3, 3]
    for turn, far in product(TURNS, (0.0, *FARTHER)) if short >= 0.0 else ():
        R = rotation(way, turn)
        for side in sides if far else sides[:1]:
            moved = T.copy()
            moved[:3, :3] = R @ T[:3, :3]
            moved[:3, 3] = middle + R @ (T[:3, 3] - middle) + far * short * side
            if _has_room(around, body, moved, room):
                return False
    return short >= 0.0


def _has_room(around: Solid, body: Solid, T: Array, room: float) -> bool:
    """Whether a body at T in the frame of another has so much room, or is no deeper where that is negative [m]."""
    return clearance(around, body, T, room) > room if room > 0.0 else not deeper(around, body, T, -room)
