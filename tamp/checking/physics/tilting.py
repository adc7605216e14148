"""What is pressed beyond what carries it tilts, by however little: does what stands on it roll off, or tip over?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.physics import equilibrium
from tamp.checking.physics.round_bodies.perching import rolls_on, tilting_axes
from tamp.checking.physics.support import balanced, carriers, height_above
from tamp.checking.scene import TABLE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

SWINGS = 3.0
"""How many times as far something leans, at most, that stands on what tilts and swings back."""
LEVER = 0.01
"""Nearer to what carries it than this something is not pressed down by as much as is said [m]."""
FARTHEST = 0.5
"""What leans so far falls [rad]."""


def tilted_off(
    scene: Scene, state: State, name: str, points: Array, deep: float, allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What stands on an object, and rolls off or tips over as that is pressed down: sentence, bodies.

    Args:
        scene: the bodies.
        state: where all of them are.
        name: the object.
        points: where it is pressed, shape (n, 3); over what carries it it does not give way.
        deep: how far [m].
        allow: tolerances.
    """
    base = np.concatenate([np.zeros((0, 3)), *carriers(scene, state, name, allow).points.values()])
    if not len(base) or not len(points) or not above(scene, state, name, allow):
        return
    beyond = -equilibrium.inside(base[:, :2], points[:, :2]).max()
    if beyond > 0.0:
        pressed = f"which is pressed {1000 * deep:.1f} mm down"
        for other, how in falls_off(scene, state, name, deep / max(beyond, LEVER), allow):
            yield f"{other} {how}, as {name} tilts under it, {pressed}", (other, name)


def falls_off(scene: Scene, state: State, name: str, lean: float, allow: Tolerances) -> Iterator[tuple[str, str]]:
    """What stands on an object, or on what does, and does not stay as that tilts and swings back: name, and how.

    The object tilts by `lean` [rad].
    """
    lean = min(SWINGS * lean, FARTHEST)
    for other in above(scene, state, name, allow):
        if any(rolls_on(scene, state, other, way, allow) for way in tilting_axes(scene, state, (other,))):
            yield other, "rolls off"
            continue
        margin = float(np.tan(lean)) * height_above(scene, other, state.poses[other])
        if balanced(scene, state, other, carriers(scene, state, other, allow), allow, margin) < margin:
            yield other, "tips over"


def above(scene: Scene, state: State, name: str, allow: Tolerances) -> list[str]:
    """All that stands on an object, and on what does."""
    waiting, seen = [name], [name]
    while waiting:
        lower = waiting.pop()
        for other in sorted(state.standing(scene).keys() - {TABLE, *seen}):
            if lower in carriers(scene, state, other, allow).bodies:
                seen.append(other)
                waiting.append(other)
    return seen[1:]
