"""Surfaces that are not convex: is there a solid inside, and of which convex pieces; found once, kept by content."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.errors import TaskError
from tamp.task.mesh.cache import cached, content_key

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Points = NDArray[np.float64]
    Faces = NDArray[np.int64]


def convex_pieces(path: Path, vertices: Points, faces: Faces) -> list[Points]:
    """Vertices, shape (n, 3) [m], of convex pieces that together are the solid inside a surface.

    Args:
        path: the mesh file, to be named in errors.
        vertices: shape (n, 3) [m].
        faces: shape (m, 3), indices into `vertices`.

    Raises:
        TaskError: where the surface is not closed, cuts through itself, or cannot be decomposed.
    """
    import numpy as np

    from tamp.task.mesh.surface import closed, self_intersection

    kept = np.unique(faces)
    vertices, faces = vertices[kept], np.searchsorted(kept, faces)
    if not closed(vertices, faces):
        raise TaskError(
            f"{path}: the mesh is neither convex nor closed: not every edge joins two triangles; close it, or give its "
            "convex parts as groups"
        )
    if (pair := self_intersection(vertices, faces)) is not None:
        raise TaskError(f"{path}: the mesh intersects itself (triangles {pair[0]} and {pair[1]}); repair it first")
    key = content_key("coacd-1", vertices.tobytes(), faces.tobytes())
    try:
        stored = cached("parts", key, lambda: _decomposed(path, vertices, faces))
    except ValueError as error:
        raise TaskError(f"{path}: the mesh is not convex, and {error}; give its convex parts as groups") from error
    return [np.asarray(stored[name], dtype=np.float64) for name in sorted(stored)]


def _decomposed(path: Path, vertices: Points, faces: Faces) -> dict[str, Points]:
    from tamp.task.mesh.decompose import LIMIT_S, decompose

    logging.getLogger(__name__).warning("%s: making convex parts, once; takes up to %d s", path, LIMIT_S)
    return {f"{i:04d}": points for i, points in enumerate(decompose(vertices, faces))}
