"""Do closing pads hold what they touch, or do their rims press on a slope and slip off it?

What bulges between the pads meets their faces, which press straight on it. What grows wider towards a rim, and on
beyond it, meets only the rim, which presses along the normal of the object's surface, or across itself on an edge.
"""

from __future__ import annotations

from itertools import combinations, product
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

INSET = 0.001  # from the pad's outline to where its rim meets the object [m]
AS_FAR = 2e-4  # what lies so little within the outermost point meets the pad with it [m]
MET = 0.0018  # what lies farther from where a pad stops is not what has stopped it [m]
MEETING = 1e-6  # faces whose planes are no farther from a point meet in it [m]
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

    It meets the outermost corners of what the object has before it. A pad's face presses straight on them; of those
    that its rim cuts out of the object, the least steep counts.
    """
    rim = half[1:] - INSET
    met: list[tuple[Array, Array, Array, Array]] = []  # how far out, before which points of the pad, and the faces
    for part in parts:
        A, b = half_spaces(part)
        across, normals, offsets = _corners(part, R, t, rim), A @ R.T, b + A @ R.T @ t
        out = _height(normals, offsets, across, side)
        met.append((np.where(np.abs(out) > half[0], -np.inf, out), across, normals, offsets))
    outermost = max((float(out.max()) for out, *_ in met), default=-np.inf)
    if not np.isfinite(outermost):
        return 0.0
    if outermost < least:
        return np.inf
    steep = np.inf
    for out, across, normals, offsets in met:
        for index in np.flatnonzero(out > outermost - AS_FAR):
            point = np.array([side * out[index], *across[index]])
            rims = np.sign(point[1:]) * (np.abs(point[1:]) > rim - 1e-9)
            faces = normals[np.abs(normals @ point - offsets) < MEETING]
            if rims.any() or len(faces) > 1:  # else it lies amid a face, opposite to a corner of the other side
                steep = min(steep, _between(faces, side, rims))
    return steep


def _corners(part: Part, R: Array, t: Array, rim: Array) -> Array:
    """Where a part has corners within |y| <= rim[0], |z| <= rim[1], or edges that cross the outline of that, (n, 2)."""
    points = (part.vertices @ R.T + t)[:, 1:]
    pairs = np.concatenate([part.faces[:, [0, 1]], part.faces[:, [1, 2]], part.faces[:, [2, 0]]])
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]  # each edge belongs to two faces
    start, way = points[pairs[:, 0]], points[pairs[:, 1]] - points[pairs[:, 0]]
    found = [points, rim * [(1, 1), (1, -1), (-1, 1), (-1, -1)]]
    for side, axis in product((-1.0, 1.0), (0, 1)):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (side * rim[axis] - start[:, axis]) / way[:, axis]
        crosses = (share >= 0.0) & (share <= 1.0)
        found.append(start[crosses] + share[crosses, None] * way[crosses])
    candidates = np.concatenate(found)
    return np.asarray(candidates[(np.abs(candidates) <= rim + 1e-12).all(axis=1)])


def _between(normals: Array, side: float, outwards: Array) -> float:
    """How steep the line is at least along which a pad presses on faces that meet in a point.

    A rim presses across itself, along what lies between two faces that meet in an edge; the end of a rim along any.

    Args:
        normals: of the faces, shape (n, 3).
        side: which way along the closing axis is out, 1 or -1.
        outwards: for y and z, to which side the pad's rim is there, 1 or -1; 0 where it is not.
    """
    rims = np.flatnonzero(outwards)
    if not len(rims):
        return 0.0
    lines = [*normals]
    if len(rims) == 1:
        along = normals[:, 2 - rims[0]]
        lines = [normal for normal, a in zip(normals, along, strict=True) if abs(a) < 1e-6]
        for i, j in combinations(range(len(normals)), 2):
            if along[i] * along[j] < 0.0:
                lines.append(abs(along[j]) * normals[i] + abs(along[i]) * normals[j])
    facing = [line for line in lines if side * line[0] > 1e-6]
    away = [np.linalg.norm(np.maximum(-line[1:][rims] * outwards[rims], 0.0)) / (side * line[0]) for line in facing]
    return float(min(away, default=np.inf))


def _height(normals: Array, offsets: Array, across: Array, side: float) -> Array:
    """How far out lines along the closing axis leave a convex part, (n,); -inf where they miss it.

    Args:
        normals: of its faces in the pads' frame, shape (m, 3).
        offsets: of its faces from that frame's origin, shape (m,) [m].
        across: where the lines are across the axis, shape (n, 2) [m].
        side: which way along the axis is out, 1 or -1.
    """
    gap = offsets[:, None] - normals[:, 1:] @ across.T
    speed = side * normals[:, :1]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = gap / speed
    leave = np.where(speed > 1e-9, reach, np.inf).min(axis=0)
    enter = np.where(speed < -1e-9, reach, -np.inf).max(axis=0)
    missed = (enter > leave + MEETING) | ((np.abs(speed) <= 1e-9) & (gap < -MEETING)).any(axis=0)
    return np.where(missed, -np.inf, leave)
