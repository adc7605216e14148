"""Geometry as OBJ files, one group a convex part: the form that OCRTOC's collision meshes have."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import parts
from tamp.task.model import Mesh

if TYPE_CHECKING:
    from tamp.task.model import Shape

    Group = tuple[Sequence[Sequence[float]], Sequence[Sequence[int]]]


def shape_obj(shape: Shape) -> bytes:
    """The shape at its true size: a mesh's own file where that is an OBJ of that size, else its groups or parts.

    Raises:
        TaskError: where a mesh cannot be read.
    """
    if not isinstance(shape, Mesh):
        return _obj((part.vertices.tolist(), part.faces.tolist()) for part in parts(shape)).encode()
    raw = read_mesh(shape.path, shape.scale)
    if shape.scale == 1.0 and shape.path.suffix.lower() == ".obj":
        return shape.path.read_bytes()
    used = [sorted({i for face in group.tolist() for i in face}) for group in raw.groups]
    numbers = [{vertex: i for i, vertex in enumerate(kept)} for kept in used]
    return _obj(
        (raw.vertices[kept].tolist(), [[number[i] for i in face] for face in group.tolist()])
        for kept, number, group in zip(used, numbers, raw.groups, strict=True)
    ).encode()


def box_obj(name: str, lower: Sequence[float], upper: Sequence[float]) -> str:
    """A box by two opposite corners [m]."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    vertices = [(x, y, z) for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    sides = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    return _obj([(vertices, [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))])], name)


def _obj(groups: Iterable[Group], name: str = "part") -> str:
    """Groups of vertices [m] and triangles, which count from 0 in their group."""
    lines: list[str] = []
    first = 1
    for number, (vertices, faces) in enumerate(groups):
        lines.append(f"o {name}_{number}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in faces]
        first += len(vertices)
    return "\n".join(lines) + "\n"
