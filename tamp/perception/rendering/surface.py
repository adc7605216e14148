"""What bodies look like: triangles with a colour a corner."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.errors import TaskError
from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import Part, parts
from tamp.task.model import Mesh, Object, Shape

if TYPE_CHECKING:
    from numpy.typing import NDArray

GREY = (180, 180, 180)
"""Colour of what has none."""

TABLE_COLOR = (204, 189, 168)


@dataclass(frozen=True, eq=False)
class Surface:
    """A coloured triangle mesh in its body's frame; arrays are read-only.

    Attributes:
        vertices: shape (n, 3) [m].
        faces: shape (m, 3), indices into `vertices`.
        colors: of the vertices, shape (n, 3), uint8.
        parts: convex parts of the space that the body takes up, where they are known. A scan shows deep hollows as
            filled; what lies in them is inside what the body looks like, but not inside these.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    colors: NDArray[np.uint8]
    parts: tuple[Part, ...] = ()

    def __post_init__(self) -> None:
        for array in (self.vertices, self.faces, self.colors):
            array.setflags(write=False)

    @property
    def colored(self) -> bool:
        """Whether its colour differs from place to place."""
        return bool((self.colors != self.colors[0]).any())


def plain(shape: Shape, color: tuple[int, int, int] = GREY) -> Surface:
    """The surface of a shape's convex parts in one colour.

    Raises:
        TaskError: where the shape's mesh cannot be used.
    """
    pieces = parts(shape)
    first = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    vertices = np.concatenate([piece.vertices for piece in pieces])
    faces = np.concatenate([piece.faces + start for piece, start in zip(pieces, first, strict=False)])
    return Surface(vertices, faces.astype(np.int64), np.tile(np.array(color, np.uint8), (len(vertices), 1)), pieces)


@lru_cache(maxsize=256)
def read_surface(path: Path, scale: float = 1.0) -> Surface:
    """A mesh file with a colour a vertex or a texture; grey where it has neither.

    Raises:
        TaskError: where it cannot be read or has no faces.
    """
    import trimesh

    if not path.is_file():
        raise TaskError(f"{path}: no such mesh file")
    if path.suffix.lower() == ".dae":
        raw = read_mesh(path, scale)
        return Surface(raw.vertices, raw.groups[0], np.tile(np.array(GREY, np.uint8), (len(raw.vertices), 1)))
    try:
        mesh = trimesh.load(path, force="mesh", process=False)
    except Exception as error:
        # trimesh raises whatever its parsers raise; each of them means that the file is not what its name says.
        raise TaskError(f"{path}: cannot be read as a mesh: {error}") from error
    vertices = np.array(mesh.vertices, dtype=np.float64) * scale
    faces = np.array(mesh.faces, dtype=np.int64)
    if not len(faces) or not np.isfinite(vertices).all():
        raise TaskError(f"{path}: the mesh has no faces, or coordinates that are not finite")
    return Surface(vertices, faces, _vertex_colors(mesh, len(vertices)))


def _vertex_colors(mesh: object, count: int) -> NDArray[np.uint8]:
    visual = mesh.visual  # type: ignore[attr-defined]
    if visual.kind == "texture" and visual.uv is not None and getattr(visual.material, "image", None) is not None:
        visual = visual.to_color()
    if visual.kind in ("vertex", "face"):
        return np.array(visual.vertex_colors[:, :3], dtype=np.uint8)
    return np.tile(np.array(GREY, np.uint8), (count, 1))


def surface_of(obj: Object, visuals: Path | None = None) -> Surface:
    """What an object looks like: its coloured mesh where there is one, else its shape in grey.

    Args:
        obj: its shape says where the coloured mesh is looked for: `visuals`/MODEL.ply, or visual.ply beside its mesh.
            A model is called by its mesh's folder if the mesh is called collision.obj, else by its mesh's file.
        visuals: folder of coloured meshes in the same frames as the shapes.
    """
    shape, name = obj.shape, model_name(obj)
    if not isinstance(shape, Mesh):
        return plain(shape)
    places = [shape.path.parent / "visual.ply"] if visuals is None else [visuals / f"{name}.ply"]
    found = next((path for path in places if path.is_file()), None)
    return plain(shape) if found is None else replace(read_surface(found, shape.scale), parts=parts(shape))


def model_name(obj: Object) -> str:
    """What the model of an object is called: by its mesh, or by its own name where it has none."""
    if not isinstance(obj.shape, Mesh):
        return obj.name
    path = obj.shape.path
    return path.parent.name if path.stem == "collision" else path.stem


def write_ply(surface: Surface, path: Path, scale: float = 1.0) -> None:
    """Write a binary PLY with a colour a vertex; `scale` 1000 makes it millimetres."""
    vertices = np.empty(len(surface.vertices), dtype=[("xyz", "<f4", 3), ("rgb", "u1", 3)])
    vertices["xyz"], vertices["rgb"] = scale * surface.vertices, surface.colors
    faces = np.empty(len(surface.faces), dtype=[("n", "u1"), ("abc", "<i4", 3)])
    faces["n"], faces["abc"] = 3, surface.faces
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {axis}" for axis in "xyz"]
    header += [f"property uchar {color}" for color in ("red", "green", "blue")]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    path.write_bytes("\n".join(header).encode() + b"\n" + vertices.tobytes() + faces.tobytes())
