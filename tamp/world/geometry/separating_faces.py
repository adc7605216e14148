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

CLEAR, HIT, UNKNOWN = 0, 1, 2


@compiled
def sieve(
    planes: Planes,
    standing: Corners,
    boxes: tuple[Matrix, Matrix],
    ball: tuple[Matrix, float],
    corners: Matrix,
    faces: tuple[Matrix, Matrix],
    R: Matrix,
    t: Matrix,
    margin: float,
) -> NDArray[np.int8]:
    """CLEAR, HIT or UNKNOWN for a convex body at each of some poses among others, shape (n,).

    Args:
        planes: the others as half-spaces.
        standing: their corners.
        boxes: lower and upper corners of the boxes round them, shape (parts, 3) each [m].
        ball: centre and radius of a ball round the body, in its own frame [m].
        corners: of the body in its own frame, shape (k, 3) [m].
        faces: the body as half-spaces A x <= b there, shapes (m, 3) and (m,).
        R: its orientations, shape (n, 3, 3).
        t: its positions, shape (n, 3) [m].
        margin: what comes no nearer than this is clear [m], 0 or more.
    """
    A, b, ends = planes
    others, other_ends = standing
    verdicts, points = np.zeros(len(t), np.int8), np.empty(corners.shape)
    turned, offsets, middle = np.empty(faces[0].shape), np.empty(len(faces[1])), np.empty(3)
    for k in range(len(t)):
        _move(middle, ball[0], R[k], t[k])
        first = start = 0
        placed = False
        for part in range(len(ends)):
            planes_of, offsets_of = A[first : ends[part]], b[first : ends[part]]
            corners_of = others[start : other_ends[part]]
            first, start = ends[part], other_ends[part]
            if _beside(boxes[0][part], boxes[1][part], middle, ball[1] + margin):
                continue
            if not placed:
                placed = True
                for v in range(len(corners)):
                    _move(points[v], corners[v], R[k], t[k])
                _turn(turned, offsets, faces, R[k], t[k])
            if _parted(planes_of, offsets_of, points, margin) or _parted(turned, offsets, corners_of, margin):
                continue
            verdicts[k] = UNKNOWN
            if _any_inside(planes_of, offsets_of, points) or _any_inside(turned, offsets, corners_of):
                verdicts[k] = HIT
                break
    return verdicts


@compiled
def _move(moved: Matrix, point: Matrix, R: Matrix, t: Matrix) -> None:
    """Write R p + t, shape (3,)."""
    for i in range(3):
        moved[i] = t[i]
        for j in range(3):
            moved[i] += R[i, j] * point[j]


@compiled
def _turn(turned: Matrix, offsets: Matrix, faces: tuple[Matrix, Matrix], R: Matrix, t: Matrix) -> None:
    """Write the half-spaces of a body that is moved to where R and t take it."""
    for m in range(len(offsets)):
        offsets[m] = faces[1][m]
        for i in range(3):
            turned[m, i] = 0.0
            for j in range(3):
                turned[m, i] += R[i, j] * faces[0][m, j]
            offsets[m] += turned[m, i] * t[i]


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
