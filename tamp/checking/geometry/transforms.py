"""Rotations and rigid transforms as matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def rotation(axis: Array, angle: float) -> Array:
    """The turn by an angle [rad] about a unit vector, shape (3, 3), by Rodrigues' formula."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return R


def inverse(T: Array) -> Array:
    """Inverse of rigid transforms, shape (..., 4, 4)."""
    R = np.swapaxes(T[..., :3, :3], -1, -2)
    out = np.zeros_like(T)
    out[..., :3, :3] = R
    out[..., :3, 3] = -(R @ T[..., :3, 3:])[..., 0]
    out[..., 3, 3] = 1.0
    return out


def turned(T: Array, pivot: Array, axis: Array, angle: float) -> Array:
    """A pose turned about a unit axis through a point, each of shape (3,), by an angle [rad]."""
    R = rotation(axis, angle)
    found = T.copy()
    found[:3, :3] = R @ T[:3, :3]
    found[:3, 3] = R @ (T[:3, 3] - pivot) + pivot
    return found


def tilt(before: Array, after: Array) -> float:
    """How far a body tips or rolls between two poses [rad]: to turn about the vertical takes it nowhere."""
    return float(np.arccos(np.clip(before[2, :3] @ after[2, :3], -1.0, 1.0)))


def veer(before: Array, after: Array) -> float:
    """How far a body turns about the vertical between two poses, whatever it tips besides [rad]."""
    R = after[:3, :3] @ before[:3, :3].T
    along, none = 1 + R[2, 2] - R[0, 0] - R[1, 1], 1 + np.trace(R)  # squares of the quaternion's z and w, times four
    return float(2 * np.arctan2(np.sqrt(max(along, 0.0)), np.sqrt(max(none, 0.0))))
