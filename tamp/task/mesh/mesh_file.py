"""Reading mesh files into arrays, and refusing those that cannot be a real object on a table."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.errors import TaskError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MAX_FACES = 1_000_000
MAX_GROUPS = 1_000
MAX_BYTES = 512 * 2**20
CHUNK = 2**20
"""How much of a file is looked at at once [bytes]."""
MAX_INDEX = 2**31
MAX_EXTENT = 2.0
MIN_EXTENT = 0.001
FORMATS = (".obj", ".stl", ".ply", ".dae")


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A mesh as its file has it, after scaling.

    Attributes:
        vertices: shape (n, 3) [m].
        groups: per group (OBJ `o` or `g`, else one) its triangles, shape (m, 3), indices into `vertices`.
    """

    vertices: NDArray[np.float64]
    groups: tuple[NDArray[np.int64], ...]


def read_mesh(path: Path, scale: float | tuple[float, float, float] = 1.0) -> RawMesh:
    """Read an OBJ, STL, PLY or COLLADA file.

    Args:
        path: the file.
        scale: factor from the file's unit to metres, or one for each axis.

    Raises:
        TaskError: for a file that is missing, malformed, without faces, with coordinates that are not finite, of over
            512 MiB, a million faces or a thousand groups, or whose largest extent is not between 1 mm and 2 m. What is
            too large is refused before it is read in.
    """
    if path.suffix.lower() not in FORMATS:
        raise TaskError(f"{path}: unknown mesh format {path.suffix!r}; valid are {', '.join(FORMATS)}")
    if not path.is_file():
        raise TaskError(f"{path}: no such mesh file")
    try:
        _refuse_large(path)
        raw = _READERS.get(path.suffix.lower(), _read_with_trimesh)(path)
    except OSError as error:
        raise TaskError(f"{path}: cannot be read: {error.strerror}") from None
    return _checked(path, raw, scale)


def _checked(path: Path, raw: RawMesh, scale: float | tuple[float, float, float]) -> RawMesh:
    import numpy as np

    faces = sum(len(group) for group in raw.groups)
    if faces == 0 or len(raw.vertices) == 0:
        raise TaskError(f"{path}: the mesh has no faces")
    _check_count(path, faces)
    used = np.concatenate(raw.groups)
    if used.min() < 0 or used.max() >= len(raw.vertices):
        raise TaskError(f"{path}: a face refers to a vertex that is not among the {len(raw.vertices)} of the file")
    points = raw.vertices[np.unique(used)]
    if not np.isfinite(points).all():
        raise TaskError(f"{path}: the mesh has coordinates that are not finite numbers (NaN or infinity)")
    extent = float((np.ptp(points, axis=0) * np.abs(scale)).max())
    if extent > MAX_EXTENT:
        hint = ": millimetres? then scale: 0.001" if extent >= 10 else ""
        raise TaskError(f"{path}: the mesh is {extent:.4g} m large; at most {MAX_EXTENT:g} m fit a table{hint}")
    if extent < MIN_EXTENT:
        raise TaskError(f"{path}: the mesh is {extent:.4g} m large, below {MIN_EXTENT:g} m: a wrong unit?")
    vertices = raw.vertices * np.array(scale)
    vertices.setflags(write=False)
    return RawMesh(vertices, raw.groups)


def _check_count(path: Path, faces: int) -> None:
    if faces > MAX_FACES:
        raise TaskError(f"{path}: the mesh has {faces:,} faces; at most {MAX_FACES:,} are accepted, simplify it first")


def _refuse_large(path: Path) -> None:
    """Judge a file by its size and its header, or by counting words, before anything is made of it."""
    size, suffix = path.stat().st_size, path.suffix.lower()
    if size > MAX_BYTES:
        raise TaskError(f"{path}: the file has {size / 2**20:,.0f} MiB; at most {MAX_BYTES / 2**20:.0f} are accepted")
    with path.open("rb") as file:
        head = file.read(4096)
    if suffix == ".ply":
        for kind, count in re.findall(rb"element (\w+) (\d{1,18})\s", head.partition(b"end_header")[0]):
            _check_count(path, int(count) if kind == b"face" else 0)
            if int(count) > 3 * MAX_FACES:
                raise TaskError(f"{path}: the mesh has {int(count):,} of {kind.decode()}; it is too large")
    elif suffix == ".stl" and binary_stl(path):
        _check_count(path, int.from_bytes(head[80:84], "little"))
    elif suffix == ".stl":
        _check_count(path, _count(path, b"endfacet"))
    elif suffix == ".obj":
        _check_count(path, _count(path, b"\nf "))


def binary_stl(path: Path) -> bool:
    """Whether an STL file is as long as its header says, which one of text is not whatever its first word is."""
    with path.open("rb") as file:
        head = file.read(84)
    return len(head) == 84 and path.stat().st_size == 84 + 50 * int.from_bytes(head[80:84], "little")


def _count(path: Path, word: bytes) -> int:
    """How often a word occurs in a file."""
    found, rest = 0, b""
    with path.open("rb") as file:
        while chunk := file.read(CHUNK):
            found += (rest + chunk).count(word)
            rest = chunk[1 - len(word) :]
    return found


def _read_obj(path: Path) -> RawMesh:
    """Vertices and polygons of an OBJ; materials, normals and texture coordinates play no role."""
    import numpy as np

    vertices: list[list[str]] = []
    groups: list[list[tuple[int, int, int]]] = [[]]
    faces = 0
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            fields = line.split()
            if not fields:
                continue
            try:
                if fields[0] == "v":
                    vertices.append(fields[1:4])
                elif fields[0] == "f":
                    triangles = _triangles(fields[1:], len(vertices))
                    faces += len(triangles)
                    _check_count(path, faces)
                    groups[-1].extend(triangles)
                elif fields[0] in ("o", "g"):
                    groups.append([])
                    if len(groups) > MAX_GROUPS + 1:
                        raise TaskError(
                            f"{path}:{number}: the mesh has over {MAX_GROUPS:,} groups, each a convex part; "
                            "merge them, or give the surface alone"
                        )
            except ValueError as error:
                raise TaskError(f"{path}:{number}: cannot read the face {line.strip()!r}") from error
    try:
        points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    except ValueError as error:
        raise TaskError(f"{path}: a vertex does not have three coordinates") from error
    return RawMesh(points, tuple(np.array(group, dtype=np.int64) for group in groups if group))


def _triangles(corners: list[str], count: int) -> list[tuple[int, int, int]]:
    """A polygon `7/1/3 8 9 10` as a fan of triangles, indices from 0; negative ones count back from the last vertex."""
    indices = [int(corner.split("/", 1)[0]) for corner in corners]
    indices = [i - 1 if i > 0 else count + i for i in indices]
    if len(indices) < 3 or any(abs(i) > MAX_INDEX for i in indices):
        raise ValueError("a face needs three corners that there may be")
    return [(indices[0], b, c) for b, c in itertools.pairwise(indices[1:])]


def _read_with_trimesh(path: Path) -> RawMesh:
    import numpy as np
    import trimesh

    try:
        with path.open("rb") as file:  # an open file has no neighbours: textures beside it are not looked for
            mesh = trimesh.load(
                file, file_type=path.suffix[1:].lower(), force="mesh", process=False, skip_materials=True
            )
    except Exception as error:
        # trimesh raises whatever its parsers raise; each of them means that the file is not what its name says.
        said = " ".join(str(error).split())[:200]
        raise TaskError(f"{path}: cannot be read as {path.suffix[1:].upper()}: {said}") from error
    faces = np.asarray(getattr(mesh, "faces", np.empty((0, 3))), dtype=np.int64)
    vertices = np.asarray(getattr(mesh, "vertices", np.empty((0, 3))), dtype=np.float64)
    return _welded(vertices, faces)


def _read_dae(path: Path) -> RawMesh:
    from tamp.task.mesh.collada import read_collada

    try:
        return _welded(*read_collada(path))
    except (ValueError, OverflowError) as error:
        raise TaskError(f"{path}: cannot be read as DAE: {error}") from None


def _welded(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> RawMesh:
    """One group whose neighbours share vertices: an STL repeats each corner for each triangle."""
    import numpy as np

    if len(faces) and np.isfinite(vertices).all():
        vertices, inverse = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
        faces = inverse.reshape(-1)[faces]
    return RawMesh(vertices, (faces,) if len(faces) else ())


_READERS = {".obj": _read_obj, ".dae": _read_dae}
"""What trimesh does not read."""
