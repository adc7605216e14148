"""Poses moved and turned in the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def moved(T: Array, shift: Array) -> Array:
    """A pose (4, 4) moved by a shift (3,), or by several, (n, 3), to shape (n, 4, 4)."""
    poses = np.tile(T, (*shift.shape[:-1], 1, 1))
    poses[..., :3, 3] += shift
    return poses


def turned_about(pivot: Array, turn: Array, T: Array) -> Array:
    """A pose, shape (4, 4), turned by a rotation (3, 3) about a point (3,) of the world."""
    T = T.copy()
    T[:3, :3] = turn @ T[:3, :3]
    T[:3, 3] = pivot + turn @ (T[:3, 3] - pivot)
    return T


def rotation(axis: Array, angle: float) -> Array:
    """The rotation about a unit axis (Rodrigues), shape (3, 3)."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return R
