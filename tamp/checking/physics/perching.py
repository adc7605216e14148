"""Does what stands on something round stay there: on a ball, on a can that lies, on its own tip?

Contact points within a tolerance make a patch of what is a point of a ball. What is carried by one body alone,
itself on one other, needs more: tilted a little, and down again, that body must have its centre of mass higher. And
nothing stays whose own centre of mass is lower after it has rolled a little on what carries it, as long as that stays.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse, rotation
from tamp.checking.physics import equilibrium
from tamp.checking.physics.support import carriers
from tamp.checking.scene import TABLE

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

TILTS = (0.05, 0.15, 0.35)
"""By which a body is tilted [rad]."""
RISES = 1.5e-4
"""What a centre of mass must rise by on the way for a body to come back; what rolls on facets rises by less [m]."""
FALLS = 4e-4
"""What it is lower by after it has rolled a little, where it does not stay [m]."""
STEEP = 0.7
"""Vertical component of a contact normal below which it holds from aside."""
WAYS = 8
"""In which a body rolls."""
PLANE = 5e-5
"""Corners no farther apart in height are in one plane [m]."""
LEVEL = 0.1
"""Level share of an axis from which on it counts."""
NEAR = 2e-5
"""What is nearer than this touches [m]."""
STEP = 4e-4
"""How far it comes down where a gap is not certain [m]."""
LOOKS = 300


def perched(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Why an object does not stay on what carries it, since one of them rolls: sentence, bodies."""
    under = carriers(scene, state, name, allow).bodies
    if (below := _rolling(scene, state, name, allow)) is not None:
        yield f"{name} does not stay on {under[0]}, which rolls on {below}", (name, *under)
    elif _rolls_off(scene, state, name, allow):
        yield f"{name} does not stay on {' and '.join(under)}: it rolls down", (name, *under)


def _rolling(scene: Scene, state: State, name: str, allow: Tolerances) -> str | None:
    """On what the one body rolls that an object touches, or None where that does not roll on one body alone."""
    touching = carriers(scene, state, name, allow)
    if len(touching.patches) != 1 or touching.bodies in ((), (TABLE,)):
        return None
    (under,) = touching.bodies
    alone = state.without(name)
    below = carriers(scene, alone, under, allow)
    if len(below.patches) != 1 or not below.bodies:
        return None
    rolls = any(max(rises) < RISES for rises in _rises(scene, alone, under, below.bodies[0]))
    return below.bodies[0] if rolls else None


def _rolls_off(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
    """Whether an object rolls down from where it stands on what carries it: from a dome, a slope, or its own tip."""
    T, touching = state.poses[name], carriers(scene, state, name, allow)
    under = touching.bodies
    level = all((patch.normals[:, 2] > equilibrium.LEVEL).all() for patch in touching.patches.values())
    if not under or (level and _flat(scene, name, T, allow)):
        return False
    if any((patch.normals[:, 2] < STEEP).any() for patch in touching.patches.values()):
        return False  # it leans on something besides, or something holds it down
    others = {o: at for o, at in state.standing(scene).items() if o in under}
    center = scene.center_of_mass(name, T)
    pivot = np.array([*center[:2], (scene.solids[name].hull.part.vertices @ T[2, :3] + T[2, 3]).min()])
    flat = _comes_down(scene, name, T, np.eye(3), pivot, others)
    if np.isinf(flat):
        return False
    for angle in np.linspace(0.0, 2 * np.pi, WAYS, endpoint=False):
        axis = np.array([np.cos(angle), np.sin(angle), 0.0])
        rises = (_comes_down(scene, name, T, rotation(axis, tilt), pivot, others) - flat for tilt in TILTS)
        if all((last := risen) < RISES / 2 for risen in rises) and last < -FALLS:
            return True
    return False


def _flat(scene: Scene, name: str, T: Array, allow: Tolerances) -> bool:
    """Whether corners of an object in one level plane carry it."""
    corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    base = corners[corners[:, 2] < corners[:, 2].min() + PLANE]
    up = np.tile([0.0, 0.0, 1.0], (len(base), 1))
    inside = equilibrium.balance(base, up, np.ones(len(base)), scene.center_of_mass(name, T), allow.balance)
    return inside >= allow.balance


def _comes_down(scene: Scene, name: str, T: Array, R: Array, pivot: Array, others: Mapping[str, Array]) -> float:
    """How high the centre of mass of a body is that is turned about a point, and comes straight down on others [m].

    Infinite where it is in one of them above that already.
    """
    turned = T.copy()
    turned[:3, :3] = R @ T[:3, :3]
    turned[:3, 3] = pivot + R @ (T[:3, 3] - pivot)
    turned[2, 3] += scene.solids[name].radius * TILTS[-1]
    step = STEP
    for look in range(LOOKS):
        gaps = (
            clearance(scene.solids[o], scene.solids[name], inverse(at) @ turned, np.inf) for o, at in others.items()
        )
        gap = min(gaps)
        if gap < -NEAR and look == 0:
            return np.inf
        if gap < -NEAR:  # halving the way down to where it just touches: a gap of 0 may be a wider one
            turned[2, 3] += step
            step /= 2
            if step < NEAR:
                break
        turned[2, 3] -= max(gap, step)
    return float(scene.center_of_mass(name, turned)[2])


def _rises(scene: Scene, state: State, name: str, under: str) -> Iterator[tuple[float, ...]]:
    """By how much the centre of mass of a body is higher after each tilt, up to the first that it comes back from [m].

    One tuple for each way in which it is tilted.
    """
    T, center = state.poses[name], scene.center_of_mass(name, state.poses[name])
    below = {under: scene.T_world_table if under == TABLE else state.poses[under]}
    flat = _comes_down(scene, name, T, np.eye(3), center, below)
    for axis in _level_axes(scene.solids[name].hull.part.vertices @ T[:3, :3].T):
        rises = list[float]()
        for tilt in TILTS:
            rises.append(_comes_down(scene, name, T, rotation(axis, tilt), center, below) - flat)
            if rises[-1] >= RISES:
                break
        yield tuple(rises)


def _level_axes(points: Array) -> Iterator[Array]:
    """Level unit vectors along the principal axes of points (n, 3), and across them: what is round rolls about one."""
    for axis in np.linalg.eigh(np.cov(points.T))[1].T:
        length = float(np.hypot(axis[0], axis[1]))
        if length > LEVEL:
            yield np.array([axis[0], axis[1], 0.0]) / length
            yield np.array([-axis[1], axis[0], 0.0]) / length
