"""Whether something is in a body, in its hollow and not only within its box; and whether two bodies meet."""

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


def meet(a: Shape, T_a: Array, b: Shape, T_b: Array) -> bool:
    """Whether two bodies at poses in the world, shape (4, 4), have a point in common.

    Two convex parts have one just if a side of either passes through the other.

    Raises:
        TaskError: where a mesh file cannot be used.
    """
    T_a_b = np.linalg.inv(T_a) @ T_b
    T_b_a = np.linalg.inv(T_b) @ T_a
    return any(_pierces(p, T_b_a, q) or _pierces(q, T_a_b, p) for p in parts(a) for q in parts(b))


def _pierces(part: Part, T: Array, other: Part) -> bool:
    """Whether a side of a convex part, at T in the frame of another one, passes through that or lies in it."""
    points = part.vertices @ T[:3, :3].T + T[:3, 3]
    low, high = other.vertices.min(axis=0), other.vertices.max(axis=0)
    if (points.min(axis=0) > high).any() or (points.max(axis=0) < low).any():
        return False
    ends = points[np.concatenate([part.faces, part.faces[:, [1, 2, 0]]]).reshape(2, -1)]
    enters, leaves = _within(other, ends[0], ends[1] - ends[0])
    return bool(((enters <= leaves) & (enters <= 1.0) & (leaves >= 0.0)).any())


def _met(part: Part, point: Array, directions: Array) -> NDArray[np.bool_]:
    """Whether rays from a point along directions (n, 3) come upon a convex part from outside, shape (n,)."""
    enters, leaves = _within(part, np.broadcast_to(point, directions.shape), directions)
    met: NDArray[np.bool_] = (enters <= leaves) & (enters > 0.0)
    return met


def _within(part: Part, points: Array, directions: Array) -> tuple[Array, Array]:
    """From where to where lines, points and directions of shape (n, 3), are within a convex part, in lengths (n,).

    The first is the greater where they never are.
    """
    a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    height = points @ normals.T - np.einsum("ij,ij->i", normals, a)
    rising = directions @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = -height / rising
    enters = np.where(rising < 0.0, crossed, -np.inf).max(axis=1)
    leaves = np.where(rising > 0.0, crossed, np.inf).min(axis=1)
    beside = ((rising == 0.0) & (height > 0.0)).any(axis=1)
    return np.where(beside, np.inf, enters), np.where(beside, -np.inf, leaves)
