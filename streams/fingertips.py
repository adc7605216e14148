"""How fingertips touch an object from behind to push it straight ahead, slid or over its edge."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.behind import TOUCHING, upright
from tamp.streams.closing import felt
from tamp.streams.hand import hand_boxes
from tamp.streams.poses import moved
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.free_hand import FreeHand

    Array = NDArray[np.float64]

OPENINGS = (0.0, 0.04, 0.08)  # of fingers of which one pushes [m]
FARTHEST, HALVINGS = 0.09, 14  # of the search for where the hand touches the object from behind [m]
FINGER = 0.008  # half of a fingertip's width [m]
ASTRAY = 0.3  # angle between a nudge and the line from the touch to the centre of mass [rad]


def hands_behind(
    workspace: Workspace, obj: str, placement: Placement, ahead: Array, heights: Array
) -> Iterator[tuple[Array, float]]:
    """Yield upright tools, (4, 4), and openings [m] with which fingertips touch an object from behind.

    Args:
        workspace: where it is.
        obj: the object.
        placement: where it lies.
        ahead: unit vector in which it shall be pushed, level, (3,).
        heights: of the fingertips in the world, the best first [m].
    """
    aside = np.array([-ahead[1], ahead[0], 0.0])
    own = workspace.world.free_hand(Scene({obj: placement.pose.matrix}), TOUCHING, ignore=(TABLE,))
    center = (placement.pose.matrix @ np.append(workspace.world.geometries[obj].center_of_mass, 1.0))[:3]
    boxes = hand_boxes(workspace.world.robot)
    tip = float(boxes.upper[boxes.side != 0.0, 2].max())
    for height in heights:
        for beside, openings in ((ahead, (0.0,)), (-ahead, (0.0,)), (aside, OPENINGS), (-aside, OPENINGS)):
            # Of fingers that close along the way the one behind pushes, of those that close across it both do.
            width = FINGER if openings is OPENINGS else 2 * FINGER
            if not _presses_straight(workspace, obj, placement, center, ahead, (width, float(height))):
                continue
            for opening in openings:
                tool = upright(workspace, beside[:2])
                tool[:3, 3] = (*center[:2], height + tip)
                T = _touching(own, moved(tool, opening / 2 * ahead), opening, -ahead)
                if T is not None:
                    yield T, opening


def _touching(own: FreeHand, tool: Array, opening: float, back: Array) -> Array | None:
    """The tool drawn back until the hand just touches the object that it is in; None where it is not or stays."""
    if not own.hit(tool, opening) or own.hit(moved(tool, FARTHEST * back), opening):
        return None
    near, clear = 0.0, FARTHEST
    for _ in range(HALVINGS):
        middle = (near + clear) / 2
        near, clear = (middle, clear) if own.hit(moved(tool, middle * back), opening) else (near, middle)
    return moved(tool, clear * back)


def _presses_straight(
    workspace: Workspace, obj: str, placement: Placement, center: Array, ahead: Array, finger: tuple[float, float]
) -> bool:
    """Whether a flat finger that reaches so far to both sides and down to a height [m] touches behind the centre."""
    T = placement.pose.matrix
    points = felt(workspace, obj) @ T[:3, :3].T + T[:3, 3]
    aside = (points - center) @ [-ahead[1], ahead[0], 0.0]
    touched = np.flatnonzero((np.abs(aside) < finger[0]) & (points[:, 2] > finger[1]))
    if not len(touched):
        return False
    first = touched[((points - center) @ ahead)[touched].argmin()]
    return bool(abs(aside[first]) < np.tan(ASTRAY) * -((points[first] - center) @ ahead))
