"""Whether something is in a body: in its hollow, not only within its box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import bounds, parts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.mesh.parts import Part
    from tamp.task.model import Shape

    Array = NDArray[np.float64]

HORIZON = 72
"""Level directions in which walls are looked for."""
WALLED = 0.75
"""Share of them beyond which walls stand all round: a corner of two walls, or an L, has no more."""


def lies_in(shape: Shape, T: Array, container: Shape, T_container: Array) -> bool:
    """Whether a body lies in another one, each of a shape and at a pose in the world, shape (4, 4).

    The centre of its box is within the box of the other, whose walls stand round more than three quarters of it, and
    not under a roof without a floor. A ring is not in the peg that stands in it: there are no walls round its centre.

    Raises:
        TaskError: where a mesh file cannot be used.
    """
    middle = np.mean(bounds(shape), axis=0)
    return _encloses(container, T_container, T[:3, :3] @ middle + T[:3, 3])


def _encloses(container: Shape, T_world_container: Array, point: Array) -> bool:
    R = T_world_container[:3, :3]
    local = R.T @ (point - T_world_container[:3, 3])
    lower, upper = bounds(container)
    if (local < lower).any() or (local > upper).any():
        return False
    angles = np.linspace(0.0, 2 * np.pi, HORIZON, endpoint=False)
    level = np.stack([np.cos(angles), np.sin(angles), np.zeros(HORIZON)], axis=1)
    directions = np.vstack([level, (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]) @ R
    met = np.any([_met(part, local, directions) for part in parts(container)], axis=0)
    roofed, floored = met[HORIZON:]
    return bool(met[:HORIZON].mean() > WALLED and (floored or not roofed))


def _met(part: Part, point: Array, directions: Array) -> NDArray[np.bool_]:
    """Whether rays from a point along directions (n, 3) come upon a convex part from outside, shape (n,)."""
    a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    height = np.einsum("ij,ij->i", normals, point - a)
    if (height <= 0.0).all():
        return np.zeros(len(directions), dtype=bool)
    rising = directions @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = -height / rising
    enters = np.where(rising < 0.0, crossed, -np.inf).max(axis=1)
    leaves = np.where(rising > 0.0, crossed, np.inf).min(axis=1)
    beside = ((rising == 0.0) & (height > 0.0)).any(axis=1)
    met: NDArray[np.bool_] = ~beside & (enters <= leaves) & (leaves > 0.0)
    return met
