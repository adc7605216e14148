"""Convex parts as half-spaces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part

    Array = NDArray[np.float64]
    Planes = tuple[Array, Array, NDArray[np.int64]]
    """Outward unit normals (m, 3), offsets (m,) [m], and where each part's planes end among them (parts,)."""


@lru_cache(maxsize=4096)
def half_spaces(part: Part) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The part as {x : A x <= b}, each of its planes once; A has unit rows; shapes (m, 3) and (m,), read-only."""
    corners = part.vertices[part.faces]
    A = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(A, axis=1)
    kept = lengths > 1e-14
    A, first = A[kept] / lengths[kept, None], corners[kept, 0]
    A *= np.where(np.einsum("ij,ij->i", A, part.vertices.mean(0) - first) > 0, -1.0, 1.0)[:, None]
    planes = np.column_stack([A, np.einsum("ij,ij->i", A, first)])
    _, once = np.unique(np.round(planes, 7), axis=0, return_index=True)
    planes = planes[np.sort(once)]
    planes.setflags(write=False)
    return planes[:, :3], planes[:, 3]


def joined(each: Iterable[tuple[Array, Array]]) -> Planes:
    """Several parts as half-spaces, one after the other."""
    several = list(each)
    A = np.concatenate([np.empty((0, 3)), *(A for A, _ in several)])
    b = np.concatenate([np.empty(0), *(b for _, b in several)])
    return A, b, np.cumsum([len(b) for _, b in several], dtype=np.int64)


def placed_planes(each: Sequence[tuple[Planes, Array]]) -> Planes:
    """The planes of several bodies, each with its `T_world_body`, shape (4, 4), in the world."""
    turned = [A @ T[:3, :3].T for (A, _, _), T in each]
    offsets = [b + A @ T[:3, 3] for A, ((_, b, _), T) in zip(turned, each, strict=True)]
    ends = shifted_ends([ends for (_, _, ends), _ in each])
    return np.concatenate([np.empty((0, 3)), *turned]), np.concatenate([np.empty(0), *offsets]), ends


def shifted_ends(each: Sequence[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Where parts end in an array that joins several, of each of which it is known where its parts end in it."""
    first = np.cumsum([0, *(int(ends[-1]) for ends in each)])
    shifted = [ends + start for ends, start in zip(each, first, strict=False)]
    return np.concatenate([np.empty(0, np.int64), *shifted])
