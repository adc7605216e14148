"""Does what stands on a level face lie flat on it? What stands tilted by a tolerance rights itself, or lies down.

A body whose centre of mass is beside all that it really touches turns over the nearest of that, until more of it
touches, and so on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import turned
from tamp.checking.physics.support import carriers
from tamp.checking.scene import TABLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

TOUCHING = 2e-4
"""Corners no higher than that above the lowest touch what carries them [m]."""
LEVEL = 0.9999
"""Vertical component from which on a face is level."""
FALLS = 4e-4
"""By how much its centre of mass comes down, or else it only rolls over facets [m]."""
TURNS = 12
"""Over edges, after which a body rolls."""
FAN = np.stack([np.cos(angles := np.linspace(0.0, 2 * np.pi, 72, endpoint=False)), np.sin(angles)])
"""Level directions in which it is asked how far what touches reaches, unit vectors in columns."""
UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Tip:
    """One turn of a body over what it stands on.

    Attributes:
        ahead: the level unit vector to the side that it tips to, shape (3,).
        beyond: how far its centre of mass is beyond all that touches, that way [m].
        angle: by which it turns [rad].
        pivot: about which it does, shape (3,).
        pose: where it is then, T_world_object, shape (4, 4).
    """

    ahead: Array
    beyond: float
    angle: float
    pivot: Array
    pose: Array


def tips(scene: Scene, name: str, T: Array) -> Iterator[Tip]:
    """How an object at T turns over on a level plane below it, slowly, until it lies flat."""
    for _ in range(TURNS):
        corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
        touching = corners[corners[:, 2] < corners[:, 2].min() + TOUCHING]
        reach = ((touching - scene.center_of_mass(name, T))[:, :2] @ FAN).max(axis=0)
        worst = int(reach.argmin())
        if reach[worst] > -TOUCHING:
            return
        ahead = np.append(FAN[:, worst], 0.0)  # that way the centre of mass is beyond all that touches
        pivot = touching[(touching @ ahead).argmax()]
        forward, high = (corners - pivot) @ ahead, corners[:, 2] - pivot[2]
        in_front = forward > TOUCHING
        angle = float(np.arctan2(high[in_front], forward[in_front]).min(initial=np.pi))
        T = turned(T, pivot, np.cross(UP, ahead), angle)
        yield Tip(ahead, -float(reach[worst]), angle, pivot, T)


def righted(scene: Scene, state: State, name: str, allow: Tolerances) -> float:
    """How far an object that stands on one level face moves until it lies flat on it, as the score measures it [m].

    0 where it stands on anything else, and where it only rolls over facets, which stand for something round.
    """
    return scene.displacement(name, state.poses[name], lain(scene, state, name, allow))


def lain(scene: Scene, state: State, name: str, allow: Tolerances) -> Array:
    """Where an object is that has righted itself on the level face that it stands on, or lain down, shape (4, 4)."""
    T = state.poses[name]
    if not on_level_face(scene, state, name, allow):
        return T
    for tip in tips(scene, name, T):
        T = tip.pose
    fallen = scene.center_of_mass(name, state.poses[name])[2] - scene.center_of_mass(name, T)[2]
    return T if fallen > FALLS else state.poses[name]


def on_level_face(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether all that an object touches is one convex body, whose level face is under all of it that is near."""
    under = carriers(scene, state, name, allow)
    if len(under.patches) != 1 or not under.bodies:
        return False
    (below,) = under.bodies
    if below == TABLE:
        return True
    T, solid = state.poses[below], scene.solids[below]
    normals, offsets = solid.hull.planes
    level = normals @ T[2, :3] > LEVEL
    if len(solid.pieces) > 1 or not level.any():
        return False
    top = offsets[level].max() + T[2, 3]
    corners = scene.solids[name].hull.part.vertices @ state.poses[name][:3, :3].T + state.poses[name][:3, 3]
    near = corners[corners[:, 2] < top + allow.drop]
    inside = (near - T[:3, 3]) @ T[:3, :3] @ normals[~level].T - offsets[~level]
    return bool(inside.max(initial=-np.inf) < 0.0)
