"""What settling explains of the difference between where an object is written and where it is said to stand.

An object that is written in the air falls straight down until it touches something. Where it is in balance there it
stays; where it is not, or only just, it may tip or roll on, down and as far aside as it turns or has fallen. What is
written inside another body is pushed out, and a heap of which one body settles may jostle its others a little. Nothing
else moves by itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.physics.support import balanced, carriers

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

LANDED = 2e-4
"""What is nearer than this to another body has come down on it [m]."""
LOOKS = 200
"""Of a fall; each falls by what is certainly free."""


def unexplained(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> float:
    """How far an object is from where settling may have left it, as the score measures displacements [m]; 0 if not.

    Args:
        scene: the bodies.
        state: where all of them are said to stand.
        name: the object.
        written: object -> where the task puts it, T_world_object, shape (4, 4).
        allow: tolerances.
    """
    said, began = state.poses[name], written[name]
    far = scene.displacement(name, began, said)
    if far <= allow.settling:
        return 0.0
    inside, fallen = _falls(scene, state, name, began, allow)
    left = scene.displacement(name, fallen, said)
    if left <= allow.settling + 2 * max(inside, 0.0):
        return 0.0
    if left <= allow.jostling and _jostled(scene, state, name, written, allow):
        return 0.0
    drop = float(began[2, 3] - fallen[2, 3])
    if _steady(scene, state, name, fallen, drop, allow):
        return left
    way = scene.center_of_mass(name, said) - scene.center_of_mass(name, fallen)
    cosine = (np.trace(said[:3, :3].T @ fallen[:3, :3]) - 1) / 2
    rolled = scene.solids[name].radius * float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    aside = float(np.hypot(way[0], way[1])) - allow.settling - drop - rolled
    beyond = max(aside, far - allow.falling, float(way[2]) - allow.settling - 2 * max(inside, 0.0))
    return beyond if beyond > 0.0 else 0.0


def _falls(scene: Scene, state: State, name: str, written: Array, allow: Tolerances) -> tuple[float, Array]:
    """How deep an object is written in others [m], and where it comes down if it falls straight."""
    others, T, inside = state.without(name).standing(scene), written.copy(), -np.inf
    for look in range(LOOKS):
        room = min(
            clearance(scene.solids[other], scene.solids[name], inverse(others[other]) @ T, allow.contact)
            for other in sorted(others)
        )
        inside = -room if look == 0 else inside
        if room < LANDED or written[2, 3] - T[2, 3] > allow.falling:
            break
        T[2, 3] -= room
    return inside, T


def _steady(scene: Scene, state: State, name: str, T: Array, drop: float, allow: Tolerances) -> bool:
    """Whether an object stays where it has come down, however it is jostled, after a fall of a height [m].

    To tip or roll it must lift its centre of mass over the edge of what carries it; a share of the fall does that.
    """
    there = state.without(name)
    there.poses[name] = T
    touching = carriers(scene, there, name, allow)
    corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    height = float(scene.center_of_mass(name, T)[2] - corners[:, 2].min())
    lift = allow.bounce * drop
    margin = max(allow.steady * scene.solids[name].radius, float(np.sqrt((height + lift) ** 2 - height**2)))
    return balanced(scene, there, name, touching, allow, margin) >= margin


def _jostled(scene: Scene, state: State, name: str, written: Mapping[str, Array], allow: Tolerances) -> bool:
    """Whether an object touches, as written or in the end, another that settles."""
    for other in sorted(written):
        moves = other != name and scene.displacement(other, written[other], state.poses[other]) > allow.settling / 2
        for poses in (written, state.poses) if moves else ():
            T = inverse(poses[name]) @ poses[other]
            if clearance(scene.solids[name], scene.solids[other], T, allow.contact) <= allow.standing:
                return True
    return False
