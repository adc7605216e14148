"""Shapes as convex parts: the one place where every room of the house gets its geometry from.

A primitive is one part, or the polytope inscribed in it. An OBJ's groups are taken as the convex parts they are;
whatever is not convex is decomposed and kept in the user's cache folder by content.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.errors import TaskError
from tamp.task.mesh.concave import convex_pieces, is_convex
from tamp.task.mesh.mesh_file import RawMesh, read_mesh
from tamp.task.model import Box, Capsule, Cylinder, Mesh, Shape, Sphere

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Points = NDArray[np.float64]
    Faces = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Part:
    """A convex polytope; faces wind counter-clockwise seen from outside.

    Attributes:
        vertices: shape (n, 3) [m], in the object's frame, read-only.
        faces: shape (m, 3), indices into `vertices`, read-only.
    """

    vertices: Points
    faces: Faces

    def __post_init__(self) -> None:
        self.vertices.setflags(write=False)
        self.faces.setflags(write=False)


def parts(shape: Shape) -> tuple[Part, ...]:
    """The convex parts whose union is the shape, in the object's frame.

    Raises:
        TaskError: where a mesh file cannot be used; says which and why.
    """
    if isinstance(shape, Mesh):
        return _mesh_parts(shape.path, shape.scale, _modified(shape.path))
    return (_primitive(shape),)


def bounds(shape: Shape) -> tuple[Points, Points]:
    """Lower and upper corner of the shape's bounding box in the object's frame, each of shape (3,) [m]."""
    import numpy as np

    if isinstance(shape, Mesh):
        raw = _raw(shape.path, shape.scale, _modified(shape.path))
        points = raw.vertices[np.unique(np.concatenate(raw.groups))]
        return points.min(axis=0), points.max(axis=0)
    if isinstance(shape, Box):
        half = np.array(shape.size) / 2
    elif isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    else:
        caps = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, shape.height / 2 + caps])
    return -half, half


def watertight(shape: Shape) -> bool:
    """Whether every edge of the shape's surface is shared by exactly two triangles, each group taken for itself."""
    if not isinstance(shape, Mesh):
        return True
    from tamp.task.mesh.surface import closed

    raw = _raw(shape.path, shape.scale, _modified(shape.path))
    return all(closed(raw.vertices, group) for group in raw.groups)


def convex_hull(points: Points) -> Part:
    """The convex hull of points, shape (n, 3).

    Raises:
        ValueError: where the points lie in a plane or are fewer than four.
    """
    import numpy as np
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError as error:
        raise ValueError("the points span no volume") from error
    kept, faces = np.unique(hull.simplices, return_inverse=True)
    faces = faces.reshape(-1, 3)
    vertices = np.array(points, dtype=np.float64)[kept]
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return Part(vertices, faces)


def _modified(path: Path) -> int:
    """Time of the last change, so that a file edited during a process is read anew."""
    return path.stat().st_mtime_ns if path.is_file() else 0


@lru_cache(maxsize=1024)
def _raw(path: Path, scale: float, _changed: int) -> RawMesh:
    return read_mesh(path, scale)


@lru_cache(maxsize=1024)
def _mesh_parts(path: Path, scale: float, changed: int) -> tuple[Part, ...]:
    import numpy as np

    raw = _raw(path, scale, changed)
    pieces: list[Points] = []
    for group in raw.groups:
        convex = is_convex(raw.vertices, group)
        pieces += [raw.vertices[np.unique(group)]] if convex else convex_pieces(path, raw.vertices, group)
    found = [part for part in map(_hull, pieces) if part is not None]
    if not found:
        which = "it spans no volume" if len(pieces) == 1 else f"none of its {len(pieces)} parts spans a volume"
        raise TaskError(f"{path}: the mesh is degenerate: {which}")
    return tuple(found)


def _hull(points: Points) -> Part | None:
    """The convex hull of points; None where they span no volume."""
    try:
        return convex_hull(points)
    except ValueError:
        return None


@lru_cache(maxsize=256)
def _primitive(shape: Box | Cylinder | Sphere | Capsule) -> Part:
    import numpy as np

    if isinstance(shape, Box):
        corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        return convex_hull(corners * np.array(shape.size))
    if isinstance(shape, Cylinder):
        angle = np.arange(48) * (2 * np.pi / 48)
        ring = np.stack([shape.radius * np.cos(angle), shape.radius * np.sin(angle)], axis=1)
        return convex_hull(np.concatenate([np.c_[ring, np.full(48, z * shape.height / 2)] for z in (-1, 1)]))
    ball = _ball(shape.radius)
    if isinstance(shape, Sphere):
        return convex_hull(ball)
    lift = np.array([0.0, 0.0, shape.height / 2])
    return convex_hull(np.concatenate([ball + lift, ball - lift]))


def _ball(radius: float) -> Points:
    """Vertices on a sphere in 17 rings of 24: at most 1 % of the radius inside it, poles and equator included."""
    import numpy as np

    polar, angle = np.meshgrid(np.arange(1, 16) * np.pi / 16, np.arange(24) * np.pi / 12)
    rings = np.stack([np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle), np.cos(polar)], axis=-1)
    return radius * np.concatenate([rings.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
