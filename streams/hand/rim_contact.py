"""Do closing pads hold what they touch, or do their rims press on a slope and slip off it?

What bulges between the pads meets their faces, which press straight on it. What grows wider towards a rim, and on
beyond it, meets only the rim, which presses along the normal of the object's surface.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task.robot import PAD_FRICTION
from tamp.world.geometry.half_spaces import half_spaces

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part

    Array = NDArray[np.float64]

RAYS = 11  # on each side of a pad, at which the object is felt
INSET = 0.001  # from the pad's outline to where its rim meets the object [m]
AS_FAR = 1e-4  # what lies so little within the outermost point meets the pad with it [m]
MET = 0.0018  # what lies farther from where a pad stops is not what has stopped it [m]
TRUSTED = 0.9  # share of the friction that is counted on


def slips_off(workspace: Workspace, obj: str, grasp: Grasp) -> bool:
    """Whether one of the pads presses with its rim only, on a slope steeper than the cone of friction."""
    most = TRUSTED * PAD_FRICTION * workspace.task.object(obj).friction
    return steepness(workspace, obj, grasp) > most


def steepness(workspace: Workspace, obj: str, grasp: Grasp) -> float:
    """Tangent of the angle between the closing axis and the normal that the worse of the pads' rims presses along.

    0 where the face of each pad meets the object; infinite where a pad meets none of it, as the other one does alone.
    """
    linkage, geometry = workspace.world.robot.linkage, workspace.world.geometries[obj]
    closing = np.array(linkage.gripper.axis)
    axes = np.stack([closing, np.cross([0.0, 0.0, 1.0], closing), [0.0, 0.0, 1.0]])
    T = grasp.T_object_tool.inverse().matrix
    R, t = axes @ T[:3, :3], axes @ T[:3, 3] - (0.0, 0.0, float(linkage.depth(grasp.width)))
    half = np.array([grasp.width / 2 + grasp.clearance, *np.array(linkage.gripper.pad[1:]) / 2])
    parts = [part for part in geometry.parts if _reaches(part.vertices @ R.T + t, half)]
    return max(_pressed(parts, R, t, half, side, grasp.width / 2 - MET) for side in (1.0, -1.0))


def _reaches(points: Array, half: Array) -> bool:
    """Whether a part with these vertices (n, 3) may be in the box |x_i| <= half_i, shape (3,)."""
    return bool((points.min(axis=0) < half).all() and (points.max(axis=0) > -half).all())


def _pressed(parts: list[Part], R: Array, t: Array, half: Array, side: float, least: float) -> float:
    """The same of the pad on one side of the closing axis, which has to meet the object at least so far out [m].

    Rays along the axis from all over the pad meet the object. Where all that meet it first are at the rim the steepest
    counts: between rays the rim may meet any of these faces.
    """
    sides = [np.linspace(-1.0, 1.0, RAYS) * (h - INSET) for h in half[1:]]
    across = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 2)
    found = [_height(*half_spaces(part), R, t, across, side) for part in parts]
    heights = np.stack([height for height, _ in found]) if found else np.empty((0, len(across)))
    heights[np.abs(heights) > half[0]] = -np.inf
    if not np.isfinite(heights).any():
        return 0.0
    if heights.max() < least:
        return np.inf
    part, ray = np.nonzero(heights > heights.max() - AS_FAR)
    normals = np.stack([found[p][1][r] for p, r in zip(part, ray, strict=True)])
    at_rim = (np.abs(across[ray]) >= half[1:] - INSET - 1e-9).any(axis=1)
    steep = np.hypot(normals[:, 1], normals[:, 2]) / np.maximum(side * normals[:, 0], 1e-9)
    return float(steep.max()) if at_rim.all() else 0.0


def _height(A: Array, b: Array, R: Array, t: Array, across: Array, side: float) -> tuple[Array, Array]:
    """How far out rays along the closing axis leave a part, (n,), -inf where they miss it, and its normals there."""
    normals, offsets = A @ R.T, b + A @ R.T @ t
    gap = offsets[:, None] - normals[:, 1:] @ across.T
    speed = side * normals[:, :1]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = gap / speed
    leave = np.where(speed > 1e-9, reach, np.inf)
    enter = np.where(speed < -1e-9, reach, -np.inf).max(axis=0)
    face = leave.argmin(axis=0)
    out = leave[face, np.arange(leave.shape[1])]
    missed = (enter >= out) | ((np.abs(speed) <= 1e-9) & (gap < 0.0)).any(axis=0)
    return np.where(missed, -np.inf, out), normals[face]
