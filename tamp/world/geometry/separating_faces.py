"""What faces and corners alone say of whether convex bodies meet.

Two convex bodies are apart where a face of one of them parts it from all corners of the other, and meet where a corner
of one is in the other (the separating axis theorem; Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996). Where
neither is so, their edges decide.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry.half_spaces import Planes

    Matrix = NDArray[np.float64]
    Corners = tuple[Matrix, NDArray[np.int64]]
    """Vertices of several parts, shape (n, 3) [m], and where each part's end among them, shape (parts,)."""
    Others = tuple[Planes, Corners, tuple[Matrix, Matrix]]
    """Convex parts: as half-spaces; their corners; lower and upper corners of the boxes round them, (parts, 3) [m]."""
    Bodies = tuple[Planes, Corners, tuple[Matrix, Matrix]]
    """The same in their own frames, but last the centres (bodies, 3) and radii (bodies,) of balls round them [m]."""

CLEAR, HIT, UNKNOWN = 0, 1, 2


@compiled
def sieve(others: Others, bodies: Bodies, k: int, R: Matrix, t: Matrix, margin: float) -> NDArray[np.int8]:
    """CLEAR, HIT or UNKNOWN for the k-th of some convex bodies at each of some poses among others, shape (n,).

    Args:
        others: what stands around.
        bodies: of which one is asked about.
        k: which.
        R: its orientations, shape (n, 3, 3).
        t: its positions, shape (n, 3) [m].
        margin: what comes no nearer than this is clear [m], 0 or more.
    """
    verdicts = np.zeros(len(t), np.int8)
    for n in range(len(t)):
        verdicts[n] = _verdict(others, bodies, k, R[n], t[n], margin)
    return verdicts


@compiled
def sieve_each(others: Others, bodies: Bodies, R: Matrix, t: Matrix, margin: float) -> NDArray[np.int8]:
    """The same for all of them, each at one pose; after the first that is a HIT all are left CLEAR."""
    verdicts = np.zeros(len(t), np.int8)
    for k in range(len(t)):
        verdicts[k] = _verdict(others, bodies, k, R[k], t[k], margin)
        if verdicts[k] == HIT:
            break
    return verdicts


@compiled
def _verdict(others: Others, bodies: Bodies, k: int, R: Matrix, t: Matrix, margin: float) -> int:
    """CLEAR, HIT or UNKNOWN for the k-th of some bodies at a pose."""
    (A, b, ends), (standing, standing_ends), (lower, upper) = others
    (normals, offsets, face_ends), (vertices, vertex_ends), (centers, radii) = bodies
    faces_from, corners_from = (0, 0) if k == 0 else (face_ends[k - 1], vertex_ends[k - 1])
    normals, offsets = normals[faces_from : face_ends[k]], offsets[faces_from : face_ends[k]]
    corners = vertices[corners_from : vertex_ends[k]]
    points, turned, moved, middle = np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(3)
    _move(middle, centers[k], R, t)
    verdict, first, start = CLEAR, 0, 0
    for part in range(len(ends)):
        planes_of, offsets_of = A[first : ends[part]], b[first : ends[part]]
        corners_of = standing[start : standing_ends[part]]
        first, start = ends[part], standing_ends[part]
        if _beside(lower[part], upper[part], middle, radii[k] + margin):
            continue
        if not len(points):
            points, turned, moved = np.empty(corners.shape), np.empty(normals.shape), np.empty(len(offsets))
            for v in range(len(corners)):
                _move(points[v], corners[v], R, t)
            _turn(turned, moved, normals, offsets, R, t)
        if _parted(planes_of, offsets_of, points, margin) or _parted(turned, moved, corners_of, margin):
            continue
        verdict = UNKNOWN
        if _any_inside(planes_of, offsets_of, points) or _any_inside(turned, moved, corners_of):
            return HIT
    return verdict


@compiled
def _move(moved: Matrix, point: Matrix, R: Matrix, t: Matrix) -> None:
    """Write R p + t, shape (3,)."""
    for i in range(3):
        moved[i] = t[i]
        for j in range(3):
            moved[i] += R[i, j] * point[j]


@compiled
def _turn(turned: Matrix, moved: Matrix, normals: Matrix, offsets: Matrix, R: Matrix, t: Matrix) -> None:
    """Write the half-spaces of a body that is moved to where R and t take it."""
    for m in range(len(offsets)):
        moved[m] = offsets[m]
        for i in range(3):
            turned[m, i] = 0.0
            for j in range(3):
                turned[m, i] += R[i, j] * normals[m, j]
            moved[m] += turned[m, i] * t[i]


@compiled
def _beside(lower: Matrix, upper: Matrix, center: Matrix, radius: float) -> bool:
    """Whether a ball does not reach a box."""
    square = 0.0
    for i in range(3):
        beyond = max(lower[i] - center[i], center[i] - upper[i], 0.0)
        square += beyond * beyond
    return square > radius * radius


@compiled
def _parted(A: Matrix, b: Matrix, points: Matrix, margin: float) -> bool:
    """Whether all points are beyond one and the same of the planes A x = b, by more than `margin`."""
    for m in range(len(A)):
        beyond = True
        for v in range(len(points)):
            if A[m, 0] * points[v, 0] + A[m, 1] * points[v, 1] + A[m, 2] * points[v, 2] <= b[m] + margin:
                beyond = False
                break
        if beyond:
            return True
    return False


@compiled
def _any_inside(A: Matrix, b: Matrix, points: Matrix) -> bool:
    """Whether any point is in the body A x <= b."""
    for v in range(len(points)):
        inside = True
        for m in range(len(A)):
            if A[m, 0] * points[v, 0] + A[m, 1] * points[v, 1] + A[m, 2] * points[v, 2] > b[m]:
                inside = False
                break
        if inside:
            return True
    return False
