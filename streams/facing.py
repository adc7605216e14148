"""How an object is turned where it is put aside: steady, and so that a hand can put it down like that."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.clearance import hand_above_table
from tamp.streams.footing import amid, resting, stands, turned
from tamp.streams.topples import to_be_pushed
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def facing(
    workspace: Workspace, obj: str, rng: np.random.Generator, draw: int, able: Callable[[Array], bool] | None = None
) -> Array:
    """A steady orientation (3, 3): as it stands now, as its goal has it, then its other steady faces, turned.

    What only leans or is held up by others as it stands now would fall over elsewhere: that is left out.

    Args:
        workspace: where the object is.
        obj: the object.
        rng: source of the faces and of the turns about the vertical.
        draw: how many came before.
        able: which of them will do, if any does; all where it is None.
    """
    standing = [place.pose.matrix[:3, :3] for place in workspace.placements_of(obj)]
    known = [R for R in standing if stands(workspace.world.geometries[obj], R)]
    faces = resting(workspace, obj)
    if able is not None and any(map(able, [*known, *faces])):
        known, faces = list(filter(able, known)), list(filter(able, faces))
    if known and (draw < len(known) or draw % 2 == 0 or not faces):
        R = known[draw % len(known)]
    else:
        R = faces[int(rng.integers(len(faces)))]
    # The first draws keep the object as it is turned: the grasp that fits here then fits there.
    return turned(R, 0.0 if draw < len(known) else rng.uniform(-np.pi, np.pi))


def put_down(workspace: Workspace, obj: str, grasp: Grasp | None, R: Array) -> bool:
    """Whether the hand, or any where it is not known, has room to put an object turned by R (3, 3) on the table."""
    key = ("put down", obj, R.tobytes(), grasp)
    if key not in workspace.memory:
        place = amid(workspace, obj, R)
        able = hand_above_table(workspace, place.pose, grasp) if grasp else not to_be_pushed(workspace, obj, place)
        workspace.memory[key] = able
    answer: bool = workspace.memory[key]
    return answer
