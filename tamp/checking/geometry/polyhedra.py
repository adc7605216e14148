"""Loops over the corners, edges and faces of two convex polyhedra, compiled."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Indices = NDArray[np.int64]


@compiled
def parting(
    a: Array, edges_a: Indices, planes_a: tuple[Array, Array], b: Array, edges_b: Indices, planes_b: tuple[Array, Array]
) -> tuple[float, Array]:
    """How far the plane that best parts two convex polyhedra parts them, below 0 where they overlap; and its normal.

    It is a face of their Minkowski difference: one of either, or spanned by an edge of each (the separating axis test,
    Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996, for all polyhedra). All in one frame.

    Args:
        a: the corners of the first, shape (n, 3) [m].
        edges_a: pairs of those, and what lies beside them, two more or the same again, shape (m, 4); such as lie within
            a face do no harm.
        planes_a: outward unit normals, shape (k, 3), and offsets, shape (k,), of its faces.
        b: of the other, likewise.
        edges_b: of the other.
        planes_b: of the other.

    Returns:
        The distance [m], and the unit normal from the second into the first, shape (3,).
    """
    best, normal, way = -np.inf, np.zeros(3), np.zeros(3)
    for face in range(len(planes_a[0])):
        far = _least(b, planes_a[0][face]) - planes_a[1][face]
        if far > best:
            best, normal = far, -planes_a[0][face]
    for face in range(len(planes_b[0])):
        far = _least(a, planes_b[0][face]) - planes_b[1][face]
        if far > best:
            best, normal = far, planes_b[0][face].copy()
    along_a, along_b = _along(a, edges_a), _along(b, edges_b)
    for k in range(len(edges_a)):
        for other in range(len(edges_b)):
            if _between(along_a[k], along_b[other]) or _between(along_b[other], along_a[k]):
                continue
            u, v = along_a[k, 0], along_b[other, 0]
            for i in range(3):
                way[i] = u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2]
            length = np.sqrt(way[0] ** 2 + way[1] ** 2 + way[2] ** 2)
            if length <= PARALLEL:
                continue
            for i in range(3):
                way[i] /= length
            on_a, on_b = a[edges_a[k, 0]], b[edges_b[other, 0]]
            side = _side(a, on_a, way)
            if side == 0.0 or _side(b, on_b, way) != -side:
                continue
            far = 0.0
            for i in range(3):
                far += side * way[i] * (on_a[i] - on_b[i])
            if far > best:
                best, normal = far, side * way
    return best, normal


PARALLEL = 1e-9
"""Sine of an angle between edges below which they span no plane."""
LEVEL = 1e-9
"""What is no farther beyond a plane is on it [m]."""


@compiled
def _least(corners: Array, normal: Array) -> float:
    """How far the first of some corners, shape (n, 3), is along a normal [m]."""
    least = np.inf
    for corner in corners:
        least = min(least, corner[0] * normal[0] + corner[1] * normal[1] + corner[2] * normal[2])
    return least


@compiled
def _along(corners: Array, edges: Indices) -> Array:
    """Of each edge its direction d, and for each corner c beside it c x d, with c from the edge; shape (m, 3, 3)."""
    found, beside = np.empty((len(edges), 3, 3)), np.empty(3)
    for k in range(len(edges)):
        length = 0.0
        for i in range(3):
            found[k, 0, i] = corners[edges[k, 1], i] - corners[edges[k, 0], i]
            length += found[k, 0, i] ** 2
        for i in range(3):
            found[k, 0, i] /= np.sqrt(length)
        for j in range(2):
            for i in range(3):
                beside[i] = corners[edges[k, 2 + j], i] - corners[edges[k, 0], i]
            for i in range(3):
                found[k, 1 + j, i] = beside[i - 2] * found[k, 0, i - 1] - beside[i - 1] * found[k, 0, i - 2]
    return found


@compiled
def _between(edge: Array, other: Array) -> bool:
    """Whether the plane along two edges has what lies beside the first on both of its sides, as `_along` has them.

    Of most pairs it has, and no more corners need be looked at: (d x v) c = (c x d) v.
    """
    first, second = 0.0, 0.0
    for i in range(3):
        first += edge[1, i] * other[0, i]
        second += edge[2, i] * other[0, i]
    return (first < -LEVEL and second > LEVEL) or (first > LEVEL and second < -LEVEL)


@compiled
def _side(corners: Array, point: Array, normal: Array) -> float:
    """On which side of a plane through a point all corners are: 1 along its normal, -1 against it, 0 on both."""
    above, below = False, False
    for corner in corners:
        far = 0.0
        for i in range(3):
            far += normal[i] * (corner[i] - point[i])
        above = above or far > LEVEL
        below = below or far < -LEVEL
        if above and below:
            return 0.0
    return 1.0 if above else -1.0


@compiled
def looking_back(
    surface: tuple[Array, Array, NDArray[np.bool_]],
    T: Array,
    planes: tuple[Array, Array, Indices],
    boxes: tuple[Array, Array],
    near: tuple[float, float, float],
    least: tuple[float, float],
    chosen: Indices,
) -> tuple[Array, Indices, Indices]:
    """Which points of a surface lie over which faces of convex pieces, where those look back at them.

    Args:
        surface: points, shape (n, 3) [m], where it looks there, unit vectors, shape (n, 3), and which lie on an edge.
        T: where it is in the frame of the pieces, shape (4, 4).
        planes: outward unit normals, shape (m, 3), and offsets, shape (m,), of the faces of all pieces, and where those
            of each begin among them, shape (pieces + 1,).
        boxes: lower and upper corners of the boxes in which a piece may be touched, shape (pieces, 3) each.
        near: how far outside a face a point may be, how deep inside, and how far beside the faces that look back [m].
        least: a face looks back where the cosine to the opposite of a point's direction is at least the first on an
            edge, and the second elsewhere.
        chosen: the pieces that are asked.

    Returns:
        Points in the frame of the pieces, shape (found, 3), and the pieces and their faces, in the order of the pieces.
    """
    (normals, offsets, first), (lower, upper), (gap, deep, beside) = planes, boxes, near
    points, directions, count = np.empty((len(surface[0]), 3)), np.empty((len(surface[0]), 4)), 0
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for piece in chosen:
        for i in range(3):
            low[i], high[i] = min(low[i], lower[piece, i]), max(high[i], upper[piece, i])
    for k in range(len(surface[0])):
        inside = True
        for i in range(3):
            at = T[i, 3]
            for j in range(3):
                at += T[i, j] * surface[0][k, j]
            points[count, i] = at
            inside = inside and low[i] <= at <= high[i]
        if inside:
            for i in range(3):
                directions[count, i] = 0.0
                for j in range(3):
                    directions[count, i] += T[i, j] * surface[1][k, j]
            directions[count, 3] = least[0] if surface[2][k] else least[1]
            count += 1
    found, over, touching = np.empty((count * len(chosen), 3)), np.empty((count * len(chosen), 2), np.int64), 0
    for piece in chosen:
        for k in range(count):
            x, y, z = points[k]
            if not (
                lower[piece, 0] <= x <= upper[piece, 0]
                and lower[piece, 1] <= y <= upper[piece, 1]
                and lower[piece, 2] <= z <= upper[piece, 2]
            ):
                continue
            outermost, highest, aside, nearest = -np.inf, -np.inf, -np.inf, -1
            for face in range(first[piece], first[piece + 1]):
                height = x * normals[face, 0] + y * normals[face, 1] + z * normals[face, 2] - offsets[face]
                outermost = max(outermost, height)
                if outermost > gap:
                    break
                cosine = 0.0
                for i in range(3):
                    cosine += directions[k, i] * normals[face, i]
                if cosine > -directions[k, 3]:
                    aside = max(aside, height)
                elif height > highest:
                    highest, nearest = height, face - first[piece]
            if -deep <= outermost <= gap and nearest >= 0 and highest >= -deep and aside <= beside:
                found[touching] = points[k]
                over[touching] = piece, nearest
                touching += 1
    return found[:touching].copy(), over[:touching, 0].copy(), over[:touching, 1].copy()
