"""What holds of an object wherever on the table it lies is worked out once, in the middle of it, and moved from there.

Only the table's edges and the arm can tell two places on it apart.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

DIGITS = 9  # to which the orientations and heights of two placements agree that differ in nothing else


def midtable(workspace: Workspace, placement: Placement) -> Placement:
    """A placement on the table, shifted to its middle and turned about the vertical; the same one for all that differ.

    Args:
        workspace: where the table is.
        placement: of something that rests on the table.
    """
    pose = placement.pose.matrix
    T = np.eye(4)
    T[:3, :3] = _upward(np.round(pose[2, :3], DIGITS))
    T[:3, 3] = *workspace.task.table.center, round(float(pose[2, 3]), DIGITS)
    return Placement(Pose.from_matrix(T), placement.on)


def moved(fall: tuple[Pose, ...], placement: Placement) -> tuple[Pose, ...]:
    """Poses of an object that end in the middle of the table, moved so that they end at a placement like that."""
    T = placement.pose @ fall[-1].inverse()
    return (*(T @ pose for pose in fall[:-1]), placement.pose)


def _upward(up: NDArray[np.float64]) -> NDArray[np.float64]:
    """The orientation, shape (3, 3), chosen for all in which this axis of an object's own frame (3,) points up."""
    up = up / np.linalg.norm(up)
    ahead = np.eye(3)[np.argmin(np.abs(up))]
    ahead = ahead - (ahead @ up) * up
    ahead = ahead / np.linalg.norm(ahead)
    return np.stack([ahead, np.cross(up, ahead), up])
