"""The faces on which an object lies so flat that no hand can put it down on the table or pick it up there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tamp.streams.affordances.slide_path import slidable
from tamp.streams.affordances.stable_poses import amid, resting
from tamp.streams.affordances.tilts import never_too_wide, too_wide
from tamp.streams.workspace import TABLE, Workspace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


def lies_flat(workspace: Workspace, obj: str) -> bool:
    """Whether no hand can put an object down or pick it up on the table, whatever face it rests on."""
    start = workspace.start[obj]
    if start.on == (TABLE,) and not too_wide(workspace, obj, start):  # one face is enough
        return False
    flat = flat_faces(workspace, obj)
    return bool(flat) and len(flat) == len(resting(workspace, obj))


def flat_faces(workspace: Workspace, obj: str) -> list[NDArray[np.float64]]:
    """Steady orientations (3, 3) in which an object lies so flat that no hand can put it down or pick it up."""

    def found() -> list[NDArray[np.float64]]:
        rotations = [] if never_too_wide(workspace, obj) else resting(workspace, obj)
        return [R for R in rotations if slidable(workspace, obj, amid(workspace, obj, R))]

    return workspace.cache.value(("flat faces", obj), found)
