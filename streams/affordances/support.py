"""Whether an object that is let go on or in another one stays there, or slides and tips."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.stable_poses import BALANCE, STEADY, inside_by, outline
from tamp.streams.hand.finger_closing import felt
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.world.geometry.half_spaces import half_spaces

if TYPE_CHECKING:
    from numpy.typing import NDArray

NEAR = 0.004  # surface this near to the other object may rest on it [m]
UPWARD = 0.2  # what carries has at least this vertical share of its normal


def carried_by(workspace: Workspace, obj: str, placement: Placement, support: str, below: Placement) -> bool:
    """Whether an object's centre of mass is over where another one, which stands at `below`, carries it."""
    return inside_support(workspace, obj, placement, {support: below}) > BALANCE


def stands_on(workspace: Workspace, obj: str, placement: Placement, below: Mapping[str, Placement]) -> bool:
    """Whether an object is steady on others, as it would be on a plane: fingers that open do not tip it over."""
    geometry, R = workspace.world.geometries[obj], placement.pose.matrix[:3, :3]
    height = float(R[2] @ geometry.center_of_mass - (workspace.points(obj) @ R[2]).min())
    return inside_support(workspace, obj, placement, below) > max(BALANCE, STEADY * height)


def inside_support(
    workspace: Workspace, obj: str, placement: Placement, below: Mapping[str, Placement], near: float = NEAR
) -> float:
    """How far an object's centre of mass is inside what carries it, seen from above [m]; -infinity on less than a face.

    Args:
        workspace: where the object is.
        obj: the object.
        placement: where it stands.
        below: what may carry it, and where that stands; the table does where the placement says so.
        near: surface so near to what carries rests on it [m]; the result may be too large by as much.
    """
    T = placement.pose.matrix
    points = felt(workspace, obj) @ T[:3, :3].T + T[:3, 3]
    carried = _over_table(workspace, points, near) if TABLE in placement.on else np.zeros(len(points), dtype=bool)
    for support, place in below.items():
        carried |= _carried(workspace, points, support, place, near)
    corners = outline(points[carried, :2])
    center = T[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T[:3, 3]
    return inside_by(corners, center[:2]) if len(corners) > 2 else -np.inf


def _over_table(workspace: Workspace, points: NDArray[np.float64], near: float) -> NDArray[np.bool_]:
    """Which points, shape (n, 3), the table carries: what hangs over its edge it does not."""
    table = workspace.task.table
    beside = np.abs(points[:, :2] - np.array(table.center)) - np.array(table.size) / 2
    found: NDArray[np.bool_] = (points[:, 2] < near) & (beside < 0.0).all(axis=1)
    return found


def _carried(
    workspace: Workspace, points: NDArray[np.float64], support: str, below: Placement, near: float
) -> NDArray[np.bool_]:
    """Which points, shape (n, 3), are within `near` [m] of faces of a support that look up."""
    T_below = below.pose.matrix
    local = (points - T_below[:3, 3]) @ T_below[:3, :3]
    nearest, rising = np.full(len(points), np.inf), np.zeros(len(points))
    for part in workspace.world.geometries[support].parts:
        A, b = half_spaces(part)
        outside = local @ A.T - b
        face = outside.argmax(axis=1)
        distance = outside[np.arange(len(points)), face]
        nearer = distance < nearest
        nearest[nearer], rising[nearer] = distance[nearer], (A @ T_below[2, :3])[face[nearer]]
    found: NDArray[np.bool_] = (nearest < near) & (rising > UPWARD)
    return found
