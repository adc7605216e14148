"""Questions about a triangulated surface: is it closed, what does it enclose, does it intersect itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Points = NDArray[np.float64]
    Faces = NDArray[np.int64]


def closed(vertices: Points, faces: Faces) -> bool:
    """Whether every edge is shared by exactly two triangles; vertices at the same place count as one."""
    import numpy as np

    _, same = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    welded = same.reshape(-1)[faces]
    edges = np.sort(welded[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    return bool((count == 2).all())


def shells(vertices: Points, faces: Faces) -> list[Faces]:
    """The triangles of each connected piece of a surface, shapes (m,), indices into `faces`.

    Pieces hang together by the vertices that the file has them share, so that two bodies that merely touch stay two;
    where some piece is not closed then, by vertices at the same place.
    """
    import numpy as np

    _, same = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    found = _connected(faces)
    if all(closed(vertices, faces[piece]) for piece in found):
        return found
    return _connected(same.reshape(-1)[faces])


def _connected(faces: Faces) -> list[Faces]:
    """The triangles of each piece that hangs together: corners take the least index among those they are joined to."""
    import numpy as np

    label = np.arange(int(faces.max()) + 1)
    before = label - 1
    while not np.array_equal(label, before):
        before = label.copy()
        np.minimum.at(label, faces, label[faces].min(axis=1)[:, None])
        label = label[label]
    of_face = label[faces[:, 0]]
    order = np.argsort(of_face, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(of_face[order])) + 1)


def oriented(faces: Faces) -> bool:
    """Whether every edge has one triangle on each side, and both see it the right way round."""
    import numpy as np

    edges = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    forth, back = edges @ [int(faces.max()) + 1, 1], edges @ [1, int(faces.max()) + 1]
    return len(np.unique(forth)) == len(forth) and bool(np.isin(back, forth).all())


def volume(vertices: Points, faces: Faces) -> float:
    """What an oriented surface encloses, by the divergence theorem [m^3]."""
    import numpy as np

    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ni,ni->", a, np.cross(b, c))) / 6.0


def self_intersection(vertices: Points, faces: Faces) -> tuple[int, int] | None:
    """Two triangles that share no vertex and cut through each other, or None.

    An edge of one passes through the inside of the other (Moeller and Trumbore's test); triangles that merely touch or
    lie in one plane do not count.
    """
    import numpy as np

    _, same = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    welded = same.reshape(-1)[faces]
    triangles = vertices[faces]
    for first, second in _box_pairs(triangles.min(axis=1), triangles.max(axis=1)):
        apart = (welded[first][:, :, None] != welded[second][:, None, :]).all(axis=(1, 2))
        i, j = first[apart], second[apart]
        for a, b in ((i, j), (j, i)):
            hit = _edges_pierce(triangles[a], triangles[b])
            if hit.any():
                found = int(np.flatnonzero(hit)[0])
                return int(i[found]), int(j[found])
    return None


def _box_pairs(lower: Points, upper: Points) -> list[tuple[Faces, Faces]]:
    """Pairs of overlapping boxes, in chunks: sorted by x, each box against those that begin before it ends."""
    import numpy as np

    order = np.argsort(lower[:, 0], kind="stable")
    lower, upper = lower[order], upper[order]
    stop = np.searchsorted(lower[:, 0], upper[:, 0], side="right")
    count = stop - np.arange(len(order)) - 1
    chunks, start = [], 0
    while start < len(order):
        end = start + max(1, int(np.searchsorted(np.cumsum(count[start:]), 2_000_000)))
        first = np.repeat(np.arange(start, min(end, len(order))), count[start:end])
        offset = np.arange(len(first)) - np.repeat(np.cumsum(count[start:end]) - count[start:end], count[start:end])
        second = first + 1 + offset
        near = ((lower[first] <= upper[second]) & (lower[second] <= upper[first])).all(axis=1)
        chunks.append((order[first[near]], order[second[near]]))
        start = end
    return chunks


def _edges_pierce(triangles: Points, others: Points) -> NDArray[np.bool_]:
    """For each pair, shapes (n, 3, 3), whether an edge of the first passes through the inside of the second."""
    import numpy as np

    a, u, v = others[:, 0], others[:, 1] - others[:, 0], others[:, 2] - others[:, 0]
    hit = np.zeros(len(triangles), dtype=bool)
    for k in range(3):
        origin, along = triangles[:, k], triangles[:, (k + 1) % 3] - triangles[:, k]
        p = np.cross(along, v)
        determinant = np.einsum("ij,ij->i", u, p)
        scale = np.linalg.norm(along, axis=1) * np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
        slanted = np.abs(determinant) > 1e-6 * scale
        safe = np.where(slanted, determinant, 1.0)
        s = origin - a
        q = np.cross(s, u)
        x, y, t = (np.einsum("ij,ij->i", m, n) / safe for m, n in ((s, p), (along, q), (v, q)))
        inside, eps = slanted, 1e-3
        inside = inside & (x > eps) & (y > eps) & (x + y < 1 - eps) & (t > eps) & (t < 1 - eps)
        hit |= inside
    return hit
