"""Does what loses one of its supports come to rest again, nearly where it is, as things do that lean on each other?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.distances import clearance
from tamp.checking.scene import State
from tamp.checking.standing import balanced, carriers, overlaps
from tamp.checking.support import contacts
from tamp.checking.transforms import inverse, rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.scene import Scene
    from tamp.checking.support import Contacts
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

STEP = 0.001
"""How far the fastest side of a slumping object moves between two looks [m]."""


def slumps(scene: Scene, state: State, name: str, leaving: str, allow: Tolerances) -> bool:
    """Whether an object that `leaving` carried tilts by no more than `allow.drop` until the rest carries it.

    It tilts over the edge of what still carries it, to where its centre of mass lies, as every body does at first.
    What carries a third object is not let slump.
    """
    without = State({o: T for o, T in state.poses.items() if o != leaving}, state.q)
    if _carries(scene, without, name, allow):
        return False
    T = state.poses[name]
    found = _tipping(carriers(scene, without, name, allow), scene.center_of_mass(name, T))
    if found is None:
        return False
    pivot, axis = found
    angle = STEP / scene.solids[name].radius
    for k in range(1, int(np.pi / angle)):
        tilted = _turned(T, pivot, axis, k * angle)
        if scene.displacement(name, T, tilted) > allow.drop:
            return False
        without.poses[name] = tilted
        if any(True for _ in overlaps(scene, without, name, allow)):
            return False
        if balanced(scene, without, name, carriers(scene, without, name, allow), allow) >= allow.balance:
            return True
    return False


def _carries(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether anything stands on an object."""
    below = {name: (scene.solids[name], state.poses[name])}
    for other in sorted(state.poses):
        T = inverse(state.poses[name]) @ state.poses[other]
        if other == name or clearance(scene.solids[name], scene.solids[other], T, allow.contact) > allow.standing:
            continue
        if contacts(scene.solids[other], state.poses[other], below, allow.standing).bodies:
            return True
    return False


def _tipping(carried: Contacts, center: Array) -> tuple[Array, Array] | None:
    """The contact about which a body tips, and the unit axis, shape (3,) each; None where its centre is over them."""
    points = np.concatenate([np.zeros((0, 3)), *carried.points.values()])
    angles = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    ways = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    if not len(points):
        return None
    reach = ((points - center) @ ways.T).max(axis=0)
    worst = int(reach.argmin())
    if reach[worst] >= 0.0:
        return None
    return points[(points @ ways[worst]).argmax()], np.cross((0.0, 0.0, 1.0), ways[worst])


def _turned(T: Array, pivot: Array, axis: Array, angle: float) -> Array:
    """A pose turned about an axis through a point."""
    R = rotation(axis, angle)
    turned = T.copy()
    turned[:3, :3] = R @ T[:3, :3]
    turned[:3, 3] = R @ (T[:3, 3] - pivot) + pivot
    return turned
