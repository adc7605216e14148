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

MAX_SHELLS = 1_000
"""Of so many pieces that meet a mesh may be made; a scan's specks are more."""
CONVEX_TOLERANCE = 0.01
"""How far behind its own face a convex part's vertices may bulge, as a share of the part's size."""


def convex_pieces(path: Path, vertices: Points, faces: Faces) -> list[Points]:
    """Vertices, shape (n, 3) [m], of convex pieces that together are the solid inside a surface.

    Args:
        path: the mesh file, to be named in errors.
        vertices: shape (n, 3) [m].
        faces: shape (m, 3), indices into `vertices`.

    Raises:
        TaskError: where the surface, or a shell of it, is not closed, cuts through itself, or cannot be decomposed.
    """
    import numpy as np

    pieces: list[Points] = []
    for solid in _solids(path, vertices, faces):
        kept = np.unique(solid)
        corners, triangles = vertices[kept], np.searchsorted(kept, solid)
        pieces += [corners] if is_convex(corners, triangles) else _stored(path, corners, triangles)
    return pieces


def _solids(path: Path, vertices: Points, faces: Faces) -> list[Faces]:
    """The triangles of each surface to be decomposed: the whole, or its shells where those meet, as mug and handle do.

    What shells that meet enclose together is a solid as well; a cavity that is closed all round shows nowhere.
    """
    from tamp.task.mesh.surface import closed, self_intersection, shells

    if closed(vertices, faces) and self_intersection(vertices, faces) is None:
        return [faces]
    found = shells(vertices, faces)
    if len(found) > MAX_SHELLS:
        raise TaskError(f"{path}: the mesh is of {len(found):,} pieces that meet; at most {MAX_SHELLS} are accepted")
    for shell in found:
        if not closed(vertices, faces[shell]):
            raise TaskError(
                f"{path}: the mesh is neither convex nor closed: not every edge joins two triangles; close it, or give "
                "its convex parts as groups"
            )
        if (pair := self_intersection(vertices, faces[shell])) is not None:
            first, second = shell[pair[0]], shell[pair[1]]
            raise TaskError(f"{path}: the mesh intersects itself (triangles {first} and {second}); repair it first")
    return [faces[shell] for shell in found]


def _stored(path: Path, vertices: Points, faces: Faces) -> list[Points]:
    """Vertices of the convex pieces of one surface, from the cache where they are there."""
    import numpy as np

    key = content_key("coacd-1", vertices.tobytes(), faces.tobytes())
    try:
        stored = cached("parts", key, lambda: _decomposed(path, vertices, faces))
    except ValueError as error:
        raise TaskError(f"{path}: the mesh is not convex, and {error}; give its convex parts as groups") from error
    return [np.asarray(stored[name], dtype=np.float64) for name in sorted(stored)]


def is_convex(vertices: Points, faces: Faces) -> bool:
    """Whether all vertices of the faces lie on one side of each face, within a share of the size; ignores winding."""
    import numpy as np

    from tamp.task.mesh.support import Support

    corners = np.unique(faces)
    points = vertices[corners]
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    solid = area > 1e-6 * size * size  # slivers have no direction worth asking
    normal, a = normal[solid] / area[solid, None], a[solid]
    support, level = Support(points), np.einsum("ij,ij->i", normal, a)
    # What some of the points show already need not be asked of all: that is how most of what is not convex ends.
    for farthest in (support.at_least, support.exactly):
        inward = farthest(normal) - level > CONVEX_TOLERANCE * size
        if (farthest(-normal[inward]) + level[inward] > CONVEX_TOLERANCE * size).any():
            return False
    return True


def _decomposed(path: Path, vertices: Points, faces: Faces) -> dict[str, Points]:
    from tamp.task.mesh.decompose import LIMIT_S, decompose

    logging.getLogger(__name__).warning("%s: making convex parts, once; takes up to %d s", path, LIMIT_S)
    return {f"{i:04d}": points for i, points in enumerate(decompose(vertices, faces))}
