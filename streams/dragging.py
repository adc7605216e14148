"""Dragging: what was let go on one edge lies on the lower finger, and may go with the hand that draws back.

The fingers open only a little, so the object comes down on the lower one. That draws back along the object and pulls
at it by friction; the edge resists by friction on what the object was set on. Which is stronger follows from the
balance of forces and of moments about the edge (Coulomb friction, the object at rest).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.clearance import opening_for
from tamp.streams.footing import TOUCHING
from tamp.streams.skidding import friction_beneath
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task.robot import PAD_FRICTION

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task import Pose

    Array = NDArray[np.float64]

BENEATH = 0.7  # a finger is below the object where its upward side and the closing axis are this near (cosine)


def dragged(workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, tilted: Pose) -> bool:
    """Whether an object let go on one edge would go with the hand that draws back along its axis.

    Args:
        workspace: where the object is.
        obj: the object.
        placement: where it comes to lie.
        grasp: how it is held.
        tilted: T_world_object where it is let go; its lowest edge is on what it shall lie on.
    """
    gripper, T_tool = workspace.world.robot.spec.gripper, tilted.matrix @ grasp.T_object_tool.matrix
    up = tilted.matrix[:3, :3] @ placement.pose.matrix[2, :3]
    flat = float(np.hypot(*up[:2])) < 1e-9
    if flat or abs(up @ T_tool[:3, :3] @ np.array(gripper.axis)) < BENEATH:
        return False
    rising = -up[:2] / np.linalg.norm(up[:2])
    center, finger, height = _levers(workspace, obj, tilted, T_tool, rising)
    if not 0.0 < center < finger:
        return False
    sunk = (opening_for(gripper, grasp) - grasp.width) / 2
    angle = np.arccos(up[2]) - sunk / np.hypot(finger, height)
    normal, back = np.append(-np.sin(angle) * rising, np.cos(angle)), -T_tool[:3, 2]
    along = back - normal * (normal @ back)
    pull = workspace.task.object(obj).friction * PAD_FRICTION
    # The finger's force on the object, as a share of its weight.
    pressed = center / finger * np.cos(angle)
    force = pressed * (normal + pull * along / np.linalg.norm(along))
    held = friction_beneath(workspace, obj, placement) * (1.0 - force[2])
    return bool(force[:2] @ along[:2] > held * np.linalg.norm(along[:2]))


def _levers(workspace: Workspace, obj: str, tilted: Pose, T_tool: Array, rising: Array) -> tuple[float, float, float]:
    """How far the centre of mass and the tool are from the edge towards where the object rises (2,), and how high."""
    T = tilted.matrix
    points = workspace.points(obj) @ T[:3, :3].T + T[:3, 3]
    bottom = points[:, 2].min()
    edge = (points[points[:, 2] < bottom + TOUCHING, :2] @ rising).max()
    center = T[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T[:3, 3]
    return float(center[:2] @ rising - edge), float(T_tool[:2, 3] @ rising - edge), float(T_tool[2, 3] - bottom)
