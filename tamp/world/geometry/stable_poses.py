"""How a body can rest on a plane: the facets of its hull that its centre of mass stands above."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import Part

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]
    Indices = NDArray[np.int64]

FLAT = np.cos(np.radians(0.1))
"""Triangles whose normals agree this well lie in one facet."""
ALIKE = np.cos(np.radians(12.0))
"""Resting directions that agree this well are one pose, the most probable of them: a cylinder's side has no corners."""


@dataclass(frozen=True, eq=False)
class StablePose:
    """A way for a body to rest on a plane.

    Attributes:
        R: rotation from the body's frame to the plane's, z up; free about z. Shape (3, 3), read-only.
        height: height of the body's origin above the plane [m].
        probability: share of the directions of gravity from which the body, let go slowly, ends here.
    """

    R: Matrix
    height: float
    probability: float


def resting_poses(hull: Part, center: Vector) -> tuple[StablePose, ...]:
    """All ways for a body with this hull and centre of mass, shape (3,), to rest on a plane, the most probable first.

    A facet of the hull is stable where the centre of mass stands above its inside. Any other topples over the edge
    that the centre of mass lies farthest beyond, onto the neighbour there, and passes its share of directions on:
    the solid angle it fills, seen from the centre of mass.
    """
    normals, areas = _normals(hull)
    neighbours = _neighbours(hull.faces)
    facet = _facets(normals, neighbours)
    target = _resting_facet(hull, center, normals, neighbours, facet)
    share = np.zeros(len(normals))
    np.add.at(share, target[facet], _solid_angles(hull, center) / (4 * np.pi))
    # The facet's largest triangle gives its plane.
    largest = {int(facet[i]): int(i) for i in np.argsort(areas, kind="stable")}
    ranked = [(float(share[f]), largest[int(f)]) for f in np.argsort(-share, kind="stable") if share[f] > 0]
    return tuple(_merged(hull, normals, ranked))


def _merged(hull: Part, normals: Matrix, ranked: list[tuple[float, int]]) -> list[StablePose]:
    groups: list[tuple[int, float]] = []
    for share, triangle in ranked:
        for k, (first, total) in enumerate(groups):
            if normals[first] @ normals[triangle] > ALIKE:
                groups[k] = (first, total + share)
                break
        else:
            groups.append((triangle, share))
    groups.sort(key=lambda group: -group[1])
    poses = []
    for triangle, share in groups:
        down = normals[triangle]
        height = float(down @ hull.vertices[hull.faces[triangle, 0]])
        poses.append(StablePose(_turned_down(down), height, share))
    return poses


def _normals(hull: Part) -> tuple[Matrix, Vector]:
    """Outward unit normals of the triangles and their areas."""
    a, b, c = (hull.vertices[hull.faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    return normal / np.maximum(length, 1e-300)[:, None], length / 2


def _neighbours(faces: Indices) -> Indices:
    """For each triangle and each of its edges (0-1, 1-2, 2-0) the triangle on the other side, shape (m, 3)."""
    edges = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    order = np.lexsort(np.sort(edges, axis=1).T)
    other = np.empty(len(edges), dtype=np.int64)
    other[order[0::2]], other[order[1::2]] = order[1::2], order[0::2]
    return other.reshape(-1, 3) // 3


def _facets(normals: Matrix, neighbours: Indices) -> Indices:
    """The facet of each triangle, named by one of its triangles: flood over edges that do not bend."""
    facet = np.full(len(normals), -1, dtype=np.int64)
    for start in range(len(normals)):
        if facet[start] >= 0:
            continue
        facet[start], stack = start, [start]
        while stack:
            for other in neighbours[stack.pop()].tolist():
                if facet[other] < 0 and normals[other] @ normals[start] > FLAT:
                    facet[other] = start
                    stack.append(other)
    return facet


def _resting_facet(hull: Part, center: Vector, normals: Matrix, neighbours: Indices, facet: Indices) -> Indices:
    """For each facet the stable facet that the body ends on after toppling; indexed by facet."""
    start = hull.vertices[hull.faces]
    along = np.roll(start, -1, axis=1) - start
    inward = np.cross(normals[:, None], along)
    inward /= np.maximum(np.linalg.norm(inward, axis=2), 1e-300)[..., None]
    inside = np.einsum("mij,mij->mi", inward, center - start)
    inside[facet[neighbours] == facet[:, None]] = np.inf  # an edge within a facet holds nothing back
    height = np.einsum("ij,ij->i", normals, start[:, 0] - center)
    onto = facet.copy()
    worst = np.full(len(facet), -1e-9)
    for triangle, edge in np.argwhere(inside < -1e-9):
        f, other = facet[triangle], facet[neighbours[triangle, edge]]
        if inside[triangle, edge] < worst[f] and height[other] < height[f]:
            worst[f] = inside[triangle, edge]
            onto[f] = other
    # Every toppling lowers the centre of mass, so that following it ends; slivers, whose normals are all rounding, may
    # seem to topple upwards.
    while not np.array_equal(following := onto[onto], onto):
        onto = following
    return onto


def _solid_angles(hull: Part, center: Vector) -> Vector:
    """Solid angles of the triangles seen from inside [sr] (van Oosterom and Strackee, IEEE T-BME 1983)."""
    a, b, c = (hull.vertices[hull.faces[:, i]] - center for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    numerator = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = [np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (a, c))]
    angles: Vector = 2 * np.arctan2(numerator, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
    return np.maximum(angles, 0.0)


def _turned_down(normal: Vector) -> Matrix:
    """The smallest rotation that turns `normal` to -z."""
    axis = np.cross(normal, [0.0, 0.0, -1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(-normal[2])
    if sine < 1e-12:
        R = np.eye(3) if cosine > 0 else np.diag([1.0, -1.0, -1.0])
    else:
        axis /= sine
        skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        R = np.eye(3) + sine * skew + (1 - cosine) * skew @ skew
    R.setflags(write=False)
    return R
