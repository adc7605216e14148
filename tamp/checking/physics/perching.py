"""Does what stands on one body alone stay there: on a ball, or on a can that lies?

Contact points within a tolerance make a patch of what is a point of a ball. What is carried by one convex body alone,
itself on one other, needs more: tilted a little, and down again, that body must have its centre of mass higher.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse, rotation
from tamp.checking.physics.support import carriers
from tamp.checking.scene import TABLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

TILTS = (0.05, 0.15, 0.35)
"""By which a body is tilted [rad]."""
RISES = 1.5e-4
"""What a centre of mass must rise by on the way for a body to come back; what rolls on facets rises by less [m]."""
LEVEL = 0.1
"""Level share of an axis from which on it counts."""
NEAR = 2e-5
"""What is nearer than this touches [m]."""
STEP = 4e-4
"""How far it comes down where a gap is not certain [m]."""
LOOKS = 300


def perched(scene: Scene, state: State, name: str, allow: Tolerances) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Why an object does not stay on the one body that it touches: sentence, bodies."""
    touching = carriers(scene, state, name, allow)
    if len(touching.patches) != 1 or touching.bodies in ((), (TABLE,)):
        return
    (under,) = touching.bodies
    alone = state.without(name)
    below = carriers(scene, alone, under, allow)
    if len(below.patches) != 1 or not below.bodies or len(scene.solids[under].pieces) > 1:
        return
    if any(max(rises) < RISES for rises in _rises(scene, alone, under, below.bodies[0])):
        yield f"{name} does not stay on {under}, which rolls on {below.bodies[0]}", (name, under)


def _rises(scene: Scene, state: State, name: str, under: str) -> Iterator[tuple[float, ...]]:
    """By how much the centre of mass of a body is higher after each tilt, up to the first that it comes back from [m].

    One tuple for each way in which it is tilted.
    """
    T, T_under = state.poses[name], scene.T_world_table if under == TABLE else state.poses[under]
    center = scene.center_of_mass(name, T)

    def touching(R: Array) -> float:
        """How high the centre of mass of the turned body is where it comes down."""
        turned = T.copy()
        turned[:3, :3] = R @ T[:3, :3]
        turned[:3, 3] = center + R @ (T[:3, 3] - center)
        turned[2, 3] += scene.solids[name].radius * TILTS[-1]
        step = STEP
        for _ in range(LOOKS):
            gap = clearance(scene.solids[under], scene.solids[name], inverse(T_under) @ turned, NEAR)
            if gap < -NEAR:  # halving the way down to where it just touches: a gap of 0 may be a wider one
                turned[2, 3] += step
                step /= 2
                if step < NEAR:
                    break
            turned[2, 3] -= max(gap, step)
        return float(scene.center_of_mass(name, turned)[2])

    flat = touching(np.eye(3))
    for axis in _level_axes(scene.solids[name].hull.part.vertices @ T[:3, :3].T):
        rises = list[float]()
        for tilt in TILTS:
            rises.append(touching(rotation(axis, tilt)) - flat)
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
