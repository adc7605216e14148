"""Loops over many poses of a model's points in the volume, compiled: where a point falls, and what was measured there.

A volume is given by its arrays: `nearest` and `free` by cell, `origin` of the first cell, and the points of its cloud;
around it, `hidden` by coarser cells from `corner` on.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@compiled
def look_up(
    x: float,
    y: float,
    z: float,
    origin: Array,
    edge: float,
    nearest: NDArray[np.int32],
    free: NDArray[np.bool_],
    corner: Array,
    coarse: float,
    hidden: NDArray[np.bool_],
) -> tuple[int, bool]:
    """For a place: the nearest measured point or -1, and whether the place is known to be empty; see `Volume`."""
    i = math.floor((x - origin[0]) / edge)
    j = math.floor((y - origin[1]) / edge)
    k = math.floor((z - origin[2]) / edge)
    if i < 0 or j < 0 or k < 0 or i >= nearest.shape[0] or j >= nearest.shape[1] or k >= nearest.shape[2]:
        return -1, z < -edge or (z >= 0 and not _inside(x, y, z, corner, coarse, hidden))
    return nearest[i, j, k], free[i, j, k] or z < -edge


@compiled
def _inside(x: float, y: float, z: float, corner: Array, edge: float, cells: NDArray[np.bool_]) -> bool:
    """Whether a place lies in one of the cells."""
    i = math.floor((x - corner[0]) / edge)
    j = math.floor((y - corner[1]) / edge)
    k = math.floor((z - corner[2]) / edge)
    if i < 0 or j < 0 or k < 0 or i >= cells.shape[0] or j >= cells.shape[1] or k >= cells.shape[2]:
        return False
    return bool(cells[i, j, k])


@compiled
def look_up_all(
    points: Array,
    origin: Array,
    edge: float,
    nearest: NDArray[np.int32],
    free: NDArray[np.bool_],
    corner: Array,
    coarse: float,
    hidden: NDArray[np.bool_],
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """`look_up` for points, shape (n, 3)."""
    found, empty = np.empty(len(points), dtype=np.int64), np.empty(len(points), dtype=np.bool_)
    for n in range(len(points)):
        found[n], empty[n] = look_up(
            points[n, 0], points[n, 1], points[n, 2], origin, edge, nearest, free, corner, coarse, hidden
        )
    return found, empty


@compiled
def nearness(
    poses: Array,
    model: Array,
    points: Array,
    origin: Array,
    edge: float,
    nearest: NDArray[np.int32],
    free: NDArray[np.bool_],
    corner: Array,
    coarse: float,
    hidden: NDArray[np.bool_],
    reach: float,
) -> tuple[Array, Array]:
    """Shares of a model's points at poses, near a measured point and in free space, shape (n,) each.

    Args:
        poses: T_world_object, shape (n, 4, 4).
        model: points on its surface, shape (k, 3).
        points: those of the volume's cloud.
        origin: of the volume.
        edge: of its cells [m].
        nearest: measured point of each cell.
        free: whether each cell is empty.
        corner: of the cells around the volume.
        coarse: their edge [m].
        hidden: whether nobody has seen into each of those.
        reach: what is near [m].
    """
    count = len(model)
    hits, violations = np.zeros(len(poses)), np.zeros(len(poses))
    for n in range(len(poses)):
        T = poses[n]
        for m in range(count):
            a, b, c = model[m, 0], model[m, 1], model[m, 2]
            x = T[0, 0] * a + T[0, 1] * b + T[0, 2] * c + T[0, 3]
            y = T[1, 0] * a + T[1, 1] * b + T[1, 2] * c + T[1, 3]
            z = T[2, 0] * a + T[2, 1] * b + T[2, 2] * c + T[2, 3]
            p, empty = look_up(x, y, z, origin, edge, nearest, free, corner, coarse, hidden)
            if empty:
                violations[n] += 1.0
            elif p >= 0:
                off = (points[p, 0] - x) ** 2 + (points[p, 1] - y) ** 2 + (points[p, 2] - z) ** 2
                if off < reach * reach:
                    hits[n] += 1.0
    return hits / count, violations / count


@compiled
def correspondences(
    poses: Array,
    model: Array,
    facing: Array,
    points: Array,
    normals: Array,
    origin: Array,
    edge: float,
    nearest: NDArray[np.int32],
    free: NDArray[np.bool_],
    corner: Array,
    coarse: float,
    hidden: NDArray[np.bool_],
    reach: float,
    cosine: float,
) -> tuple[NDArray[np.int64], Array]:
    """The measured point that each model point belongs to at each pose, -1 for none, shape (n, k); and `violations`.

    They belong together where the measured surface passes within `reach` of the model's point [m] and faces the same
    way, by the least cosine between their normals. What belongs to nothing and lies in free space is a violation; the
    share of those is given for each pose, shape (n,).
    """
    count = len(model)
    found = np.full((len(poses), count), -1, dtype=np.int64)
    violations = np.zeros(len(poses))
    for n in range(len(poses)):
        T = poses[n]
        for m in range(count):
            a, b, c = model[m, 0], model[m, 1], model[m, 2]
            x = T[0, 0] * a + T[0, 1] * b + T[0, 2] * c + T[0, 3]
            y = T[1, 0] * a + T[1, 1] * b + T[1, 2] * c + T[1, 3]
            z = T[2, 0] * a + T[2, 1] * b + T[2, 2] * c + T[2, 3]
            p, empty = look_up(x, y, z, origin, edge, nearest, free, corner, coarse, hidden)
            if p >= 0:
                a, b, c = facing[m, 0], facing[m, 1], facing[m, 2]
                u, v, w = normals[p, 0], normals[p, 1], normals[p, 2]
                gap = (points[p, 0] - x) * u + (points[p, 1] - y) * v + (points[p, 2] - z) * w
                along = (
                    (T[0, 0] * a + T[0, 1] * b + T[0, 2] * c) * u
                    + (T[1, 0] * a + T[1, 1] * b + T[1, 2] * c) * v
                    + (T[2, 0] * a + T[2, 1] * b + T[2, 2] * c) * w
                )
                if abs(gap) < reach and along > cosine:
                    found[n, m] = p
                    continue
            if empty:
                violations[n] += 1.0
    return found, violations / count


@compiled
def normal_equations(
    poses: Array,
    model: Array,
    matched: NDArray[np.int64],
    points: Array,
    normals: Array,
    reach: float,
    floor: float,
) -> tuple[Array, Array, Array]:
    """One step of point-to-plane ICP for each pose: A (n, 6, 6), b (n, 6) and the sum of the weights (n,).

    The step is a rotation vector about the pose's origin, then a shift. Weights are Tukey's; what lies under the height
    `floor` [m] is pushed up to z = 0.
    """
    A, b, total = np.zeros((len(poses), 6, 6)), np.zeros((len(poses), 6)), np.zeros(len(poses))
    row = np.zeros(6)
    for n in range(len(poses)):
        T = poses[n]
        for m in range(len(model)):
            p = matched[n, m]
            # From the pose's origin to the model's point.
            x = T[0, 0] * model[m, 0] + T[0, 1] * model[m, 1] + T[0, 2] * model[m, 2]
            y = T[1, 0] * model[m, 0] + T[1, 1] * model[m, 1] + T[1, 2] * model[m, 2]
            z = T[2, 0] * model[m, 0] + T[2, 1] * model[m, 1] + T[2, 2] * model[m, 2]
            if p >= 0:
                u, v, w = normals[p, 0], normals[p, 1], normals[p, 2]
                gap = (points[p, 0] - x - T[0, 3]) * u + (points[p, 1] - y - T[1, 3]) * v
                gap += (points[p, 2] - z - T[2, 3]) * w
                weight = max(0.0, 1 - (gap / (1.5 * reach)) ** 2) ** 2
                row[0], row[1], row[2] = y * w - z * v, z * u - x * w, x * v - y * u
                row[3], row[4], row[5] = u, v, w
                _add(A[n], b[n], row, weight, gap)
                total[n] += weight
            height = z + T[2, 3]
            if height < floor:
                row[0], row[1], row[2] = y, -x, 0.0
                row[3], row[4], row[5] = 0.0, 0.0, 1.0
                _add(A[n], b[n], row, 1.0, -height)
    return A, b, total


@compiled
def _add(A: Array, b: Array, row: Array, weight: float, gap: float) -> None:
    for i in range(6):
        b[i] += weight * row[i] * gap
        for j in range(6):
            A[i, j] += weight * row[i] * row[j]


@compiled
def distinct(poses: Array, centers: Array, apart: float, trace: float, most: int) -> NDArray[np.int64]:
    """Indices of poses (n, 4, 4), in order, that are not near an earlier one, at most so many.

    Near is: centres (n, 3) less than `apart` from each other [m] and the trace of the turn between them over `trace`.
    """
    kept = np.empty(min(most, len(poses)), dtype=np.int64)
    count = 0
    for i in range(len(poses)):
        if count == len(kept):
            break
        new = True
        for k in range(count):
            j = kept[k]
            off = 0.0
            for a in range(3):
                off += (centers[i, a] - centers[j, a]) ** 2
            if off >= apart * apart:
                continue
            turn = 0.0
            for a in range(3):
                for c in range(3):
                    turn += poses[i, a, c] * poses[j, a, c]
            if turn > trace:
                new = False
                break
        if new:
            kept[count] = i
            count += 1
    return kept[:count]
