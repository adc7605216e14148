"""Whether an object that is let go on or in another one stays there, or slides and tips."""

from __future__ import annotations

import numpy as np

from tamp.streams.affordances.stable_poses import BALANCE, inside_by, outline
from tamp.streams.hand.finger_closing import felt
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.world.geometry.half_spaces import half_spaces

NEAR = 0.004  # surface this near to the other object may rest on it [m]
UPWARD = 0.2  # what carries has at least this vertical share of its normal


def carried_by(workspace: Workspace, obj: str, placement: Placement, support: str, below: Placement) -> bool:
    """Whether an object's centre of mass is over where another one, which stands at `below`, carries it."""
    T, T_below = placement.pose.matrix, below.pose.matrix
    points = felt(workspace, obj) @ T[:3, :3].T + T[:3, 3]
    local = (points - T_below[:3, 3]) @ T_below[:3, :3]
    nearest, rising = np.full(len(points), np.inf), np.zeros(len(points))
    for part in workspace.world.geometries[support].parts:
        A, b = half_spaces(part)
        outside = local @ A.T - b
        face = outside.argmax(axis=1)
        distance = outside[np.arange(len(points)), face]
        nearer = distance < nearest
        nearest[nearer], rising[nearer] = distance[nearer], (A @ T_below[2, :3])[face[nearer]]
    corners = outline(points[(nearest < NEAR) & (rising > UPWARD), :2])
    center = T[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T[:3, 3]
    return len(corners) > 2 and inside_by(corners, center[:2]) > BALANCE
