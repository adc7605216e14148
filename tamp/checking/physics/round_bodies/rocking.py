"""Does what is round, or stands on something round, keep its balance with all that stands on it?

Contact points within a tolerance make a strip of what is a line: on a half round that rests on its back, or on a plank
over a dome, a load would seem to be carried anywhere above that strip. What stands on one body alone is tilted a
little, with all that it carries, on what it really touches: their common centre of mass must rise.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.transforms import rotation
from tamp.checking.physics import equilibrium
from tamp.checking.physics.contacts import contacts
from tamp.checking.physics.round_bodies.perching import BROAD, PLANE, RISES, TILTS, comes_down, tilting_axes
from tamp.checking.physics.support import carriers, patch_between
from tamp.checking.scene import TABLE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy.typing import NDArray

    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances

    Array = NDArray[np.float64]

WIDE = 0.003
"""The facets of what is round are narrower than this [m]."""
FACET = 0.2
"""What comes to rest after it has tilted by no more has rocked, and not tipped [rad]."""
CLOSE = 2e-4
"""What is no farther from a body than this certainly touches it [m]."""


def rocked(
    scene: Scene, state: State, names: Iterable[str], allow: Tolerances
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Which of certain bodies tip over with what stands on them, as they stand: sentence, bodies."""
    for name in names:
        under = carriers(scene, state, name, allow).bodies
        loads = _carried(scene, state, name, under[0], allow) if len(under) == 1 else set()
        if len(loads) > 1 and _rocks(scene, state, name, under[0], sorted(loads), allow):
            on_it = ", ".join(sorted(loads - {name}))
            yield f"{name} does not keep its balance on {under[0]} with {on_it} on it", (name, *under)


def _carried(scene: Scene, state: State, name: str, under: str, allow: Tolerances) -> set[str]:
    """A body and all that it alone carries, `under` it; nothing where anything else holds any of that."""
    found, waiting, standing = {name}, [name], state.standing(scene)
    while waiting:
        one = waiting.pop()
        for other in sorted(standing.keys() - found - {one}):
            if (one, other) == (name, under) or patch_between(scene, state, one, other, allow) is None:
                continue
            if other in (TABLE, under):
                return set()
            found.add(other)
            waiting.append(other)
    return found


def _rocks(scene: Scene, state: State, name: str, under: str, loads: list[str], allow: Tolerances) -> bool:
    """Whether the common centre of mass of what a body carries, and of itself, comes lower and lower as that tilts.

    What only rocks to the facet beside it, as boxes with bulging sides do, comes to rest there.
    """
    T, below = state.poses[name], {under: state.standing(scene)[under]}
    masses = np.array([scene.task.object(one).mass for one in loads])
    center = masses @ np.array([scene.center_of_mass(one, state.poses[one]) for one in loads]) / masses.sum()
    solids = {under: (scene.solids[under], below[under])}
    friction = {under: scene.friction(name) * scene.friction(under)}
    if _flatly(scene, name, T, under, below[under], center, allow):
        return False
    if contacts(scene.solids[name], T, solids, CLOSE).balance(center, friction, BROAD) >= BROAD:
        return False
    pivot = np.array([*center[:2], (scene.solids[name].hull.part.vertices @ T[2, :3] + T[2, 3]).min()])
    flat = comes_down(scene, name, T, np.eye(3), pivot, below, center)
    if np.isinf(flat):
        return False
    for axis in tilting_axes(scene, state, (name, *(other for other in below if other != TABLE))):
        least = 0.0
        for tilt in TILTS:
            risen = comes_down(scene, name, T, rotation(axis, tilt), pivot, below, center) - flat
            if risen > least + RISES / 2:  # it comes to rest before
                break
            if risen < -RISES and tilt > FACET:
                return True
            least = min(least, risen)
    return False


def _flatly(scene: Scene, name: str, T: Array, under: str, T_under: Array, center: Array, allow: Tolerances) -> bool:
    """Whether a level face of a body stands on a level face, and a point is over both: statics have the rest."""
    corners = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    low = corners[:, 2].min()
    if not _over(corners[corners[:, 2] < low + PLANE], center, allow):
        return False
    if under == TABLE:
        return True
    for piece in scene.solids[under].pieces:
        tops = piece.part.vertices @ T_under[:3, :3].T + T_under[:3, 3]
        high = tops[:, 2].max()
        if abs(high - low) <= allow.standing and _over(tops[tops[:, 2] > high - PLANE], center, allow):
            return True
    return False


def _over(corners: Array, center: Array, allow: Tolerances) -> bool:
    """Whether a point is over a face, given by its corners, shape (n, 3), which is no facet of what is round."""
    angles = np.linspace(0.0, np.pi, 90, endpoint=False)
    across = corners[:, :2] @ np.stack([np.cos(angles), np.sin(angles)])
    up = np.tile([0.0, 0.0, 1.0], (len(corners), 1))
    wide = float((across.max(axis=0) - across.min(axis=0)).min()) > WIDE
    return wide and equilibrium.balance(corners, up, np.ones(len(corners)), center, 0.0) > -allow.balance
