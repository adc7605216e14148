"""Does what stands on a level face lie flat on it? What stands tilted by a tolerance rights itself, or lies down.

A body whose centre of mass is beside all that it really touches turns over the nearest of that, until more of it
touches, and so on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import rotation
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


def righted(scene: Scene, state: State, name: str, allow: Tolerances) -> float:
    """How far an object that stands on one level face moves until it lies flat on it, as the score measures it [m].

    0 where it stands on anything else, and where it only rolls over facets, which stand for something round.
    """
    T = state.poses[name].copy()
    if not _on_level_face(scene, state, name, allow):
        return 0.0
    for _ in range(TURNS):
        corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
        touching = corners[corners[:, 2] < corners[:, 2].min() + TOUCHING]
        reach = (touching - scene.center_of_mass(name, T))[:, :2] @ FAN
        worst = int(reach.max(axis=0).argmin())
        if reach[:, worst].max() > -TOUCHING:
            break
        ahead = np.append(FAN[:, worst], 0.0)  # that way the centre of mass is beyond all that touches
        pivot = touching[(touching @ ahead).argmax()]
        forward, high = (corners - pivot) @ ahead, corners[:, 2] - pivot[2]
        beyond = forward > TOUCHING
        turn = np.eye(4)
        turn[:3, :3] = rotation(
            np.cross(UP, ahead), float(np.arctan2(high[beyond], forward[beyond]).min(initial=np.pi))
        )
        turn[:3, 3] = pivot - turn[:3, :3] @ pivot
        T = turn @ T
    fallen = scene.center_of_mass(name, state.poses[name])[2] - scene.center_of_mass(name, T)[2]
    return scene.displacement(name, state.poses[name], T) if fallen > FALLS else 0.0


def _on_level_face(scene: Scene, state: State, name: str, allow: Tolerances) -> bool:
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
