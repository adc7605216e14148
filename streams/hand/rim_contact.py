"""Do closing pads hold what they touch, or do their rims press on a slope and slip off it?

What bulges between the pads meets their faces, which press straight on it. What grows wider towards a rim, and on
beyond it, meets only the rim, which presses along the normal of the object's surface, or across itself on an edge.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.streams.hand.squeezed import in_pads
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task.robot import PAD_FRICTION
from tamp.world.geometry.half_spaces import half_spaces, joined

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part
    from tamp.world.geometry.half_spaces import Planes
    from tamp.world.geometry.object_geometry import Geometry

    Array = NDArray[np.float64]
    Edges = tuple[Array, Array, NDArray[np.int64]]
    """Both ends of each edge (m, 3) [m], and where each part's edges end among them (parts,)."""

INSET = 0.001  # from the pad's outline to where its rim meets the object [m]
AS_FAR = 2e-4  # what lies so little within the outermost point meets the pad with it [m]
MET = 0.0018  # what lies farther from where a pad stops is not what has stopped it [m]
MEETING = 1e-6  # faces whose planes are no farther from a point meet in it [m]
ALONG = 1e-6  # what has no larger share of a direction is across it
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
    R, t = (each[[1, 0, 2]] for each in in_pads(linkage, grasp))
    half = np.array([grasp.width / 2 + grasp.clearance, *np.array(linkage.gripper.pad[1:]) / 2])
    (A, b, ends), (first, last, edge_ends) = workspace.cache.value(("faces and edges", obj), lambda: _parts(geometry))
    normals = A @ R.T
    planes, edges = (normals, b + normals @ t, ends), (first @ R.T + t, last @ R.T + t, edge_ends)
    least = grasp.width / 2 - MET
    return max(_pressed(planes, edges, half, side, least) for side in (1.0, -1.0))


def _parts(geometry: Geometry) -> tuple[Planes, Edges]:
    """A body's convex parts, their faces and their edges, in its frame."""
    each = [_edges(part) for part in geometry.parts]
    ends = np.concatenate(each, axis=1)
    return joined(map(half_spaces, geometry.parts)), (*ends, np.cumsum([edges.shape[1] for edges in each]))


def _edges(part: Part) -> Array:
    """Both ends of each edge of a part, shape (2, m, 3) [m]."""
    pairs = np.concatenate([part.faces[:, [0, 1]], part.faces[:, [1, 2]], part.faces[:, [2, 0]]])
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]  # each edge belongs to two faces
    ends: Array = part.vertices[pairs.T]
    return ends


@compiled
def _pressed(planes: Planes, edges: Edges, half: Array, side: float, least: float) -> float:
    """How steep it is where the pad on one side of the closing axis presses; see `steepness`.

    It meets the outermost corners of what the object has before it. A pad's face presses straight on them; of those
    that its rim cuts out of the object, the least steep counts.

    Args:
        planes: the faces of the object's parts in the pads' frame, whose x is the closing axis.
        edges: those of its parts.
        half: half the size of what is between the pads, shape (3,) [m].
        side: which way along the closing axis is out, 1 or -1.
        least: how far out the pad has to meet it [m].
    """
    A, b, ends = planes
    first, last, edge_ends = edges
    rim = half[1:] - INSET
    across = np.empty((4 * len(ends) + 6 * len(first), 2))
    out, of = np.empty(len(across)), np.empty(len(across), np.int64)
    count, outermost, face, edge = 0, -np.inf, 0, 0
    for part in range(len(ends)):
        begin = count
        count = _corners(first[edge : edge_ends[part]], last[edge : edge_ends[part]], rim, half[0], across, count)
        for k in range(begin, count):
            far = _height(A[face : ends[part]], b[face : ends[part]], across[k], side)
            out[k], of[k] = -np.inf if abs(far) > half[0] else far, part
            outermost = max(outermost, out[k])
        face, edge = ends[part], edge_ends[part]
    if outermost == -np.inf:
        return 0.0
    if outermost < least:
        return np.inf
    steep = np.inf
    for k in range(count):
        if out[k] > outermost - AS_FAR:
            begin = 0 if of[k] == 0 else ends[of[k] - 1]
            steep = min(steep, _steep_at(A[begin : ends[of[k]]], b[begin : ends[of[k]]], out[k], across[k], side, rim))
    return steep


@compiled
def _corners(first: Array, last: Array, rim: Array, beyond: float, across: Array, count: int) -> int:
    """Note where a part has corners within |y| <= rim[0], |z| <= rim[1], or edges that cross the outline of that.

    None where all of it is beyond what is between the pads.

    Args:
        first: one end of each edge, shape (m, 3) [m].
        last: the other end, shape (m, 3) [m].
        rim: half of the pad's sides, shape (2,) [m].
        beyond: how far out along x what is between the pads ends [m].
        across: to be filled with y and z of each, from `count` on.
        count: how many are known.

    Returns:
        How many are known then.
    """
    for axis in range(3):
        far = beyond if axis == 0 else rim[axis - 1] + INSET
        if (
            min(first[:, axis].min(), last[:, axis].min()) >= far
            or max(first[:, axis].max(), last[:, axis].max()) <= -far
        ):
            return count
    for y in (-rim[0], rim[0]):
        for z in (-rim[1], rim[1]):
            across[count, 0], across[count, 1] = y, z
            count += 1
    for m in range(len(first)):
        y, z, dy, dz = first[m, 1], first[m, 2], last[m, 1] - first[m, 1], last[m, 2] - first[m, 2]
        for share in (0.0, 1.0, (rim[0] - y) / dy, (-rim[0] - y) / dy, (rim[1] - z) / dz, (-rim[1] - z) / dz):
            if not 0.0 <= share <= 1.0:
                continue
            at_y, at_z = y + share * dy, z + share * dz
            if abs(at_y) <= rim[0] + 1e-12 and abs(at_z) <= rim[1] + 1e-12:
                across[count, 0], across[count, 1] = at_y, at_z
                count += 1
    return count


@compiled
def _height(A: Array, b: Array, across: Array, side: float) -> float:
    """How far out a line along the closing axis leaves a convex part [m]; -infinity where it misses it.

    Args:
        A: normals of its faces in the pads' frame, shape (m, 3).
        b: their offsets from that frame's origin, shape (m,) [m].
        across: where the line is across the axis, shape (2,) [m].
        side: which way along the axis is out, 1 or -1.
    """
    enter, leave = -np.inf, np.inf
    for m in range(len(A)):
        gap, speed = b[m] - A[m, 1] * across[0] - A[m, 2] * across[1], side * A[m, 0]
        if speed > 1e-9:
            leave = min(leave, gap / speed)
        elif speed < -1e-9:
            enter = max(enter, gap / speed)
        elif gap < -MEETING:
            return -np.inf
        if enter > leave + MEETING:
            return -np.inf
    return leave


@compiled
def _steep_at(A: Array, b: Array, out: float, across: Array, side: float, rim: Array) -> float:
    """How steep the line is at least along which a pad presses on the faces of a part that meet in a point.

    A rim presses across itself, along what lies between two faces that meet in an edge; the end of a rim along any.
    Amid a face, opposite to a corner of the other side, the pad does not stop: that is infinitely steep.

    Args:
        A: normals of the part's faces, shape (m, 3).
        b: their offsets, shape (m,) [m].
        out: how far out the point is [m].
        across: where it is across the closing axis, shape (2,) [m].
        side: which way along the axis is out, 1 or -1.
        rim: half of the pad's sides, shape (2,) [m].
    """
    rims = np.sign(across) * (np.abs(across) > rim - 1e-9)
    distance = side * out * A[:, 0] + across[0] * A[:, 1] + across[1] * A[:, 2] - b
    meeting = np.flatnonzero(np.abs(distance) < MEETING)
    on_y, on_z = rims[0] != 0.0, rims[1] != 0.0
    if not (on_y or on_z):
        return 0.0 if len(meeting) > 1 else np.inf
    steep, along = np.inf, 2 if on_y else 1
    for i in meeting:
        if (on_y and on_z) or abs(A[i, along]) < ALONG:
            steep = min(steep, _slope(A[i], side, rims))
        for j in meeting:
            if not (on_y and on_z) and A[i, along] > 0.0 > A[j, along]:
                steep = min(steep, _slope(A[i, along] * A[j] - A[j, along] * A[i], side, rims))
    return steep


@compiled
def _slope(line: Array, side: float, rims: Array) -> float:
    """How steeply a rim slips off outwards that presses along a line, shape (3,); infinite where that does not face it.

    `rims`: for y and z, to which side the pad's rim is there, 1 or -1; 0 where it is not.
    """
    if side * line[0] <= ALONG:
        return np.inf
    aside, down = max(-line[1] * rims[0], 0.0), max(-line[2] * rims[1], 0.0)
    return float(np.hypot(aside, down) / (side * line[0]))
