"""Telling apart by colour the poses that a shape's symmetry makes alike."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.models.color import difference
from tamp.perception.estimation.models.object_model import ObjectModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST = 600
"""Points that are compared at each pose."""

NEAR = 0.010
"""A measured point takes its colour from the model's surface at most this far away [m]."""


def turned_by_color(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> Array:
    """The pose among those that the shape cannot tell from a given one whose colours fit best, shape (4, 4).

    Args:
        cloud: what was measured.
        model: the object.
        pose: where it is but for its symmetries.
        points: indices of the points that belong to it.
    """
    poses = pose @ model.symmetries
    if len(poses) == 1 or not model.colored or len(points) < 10:
        return pose
    some = points[:: max(1, len(points) // MOST)]
    return np.asarray(poses[int(np.argmin([mismatch(cloud, model, T, some) for T in poses]))])


def mismatch(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> float:
    """Mean difference between the measured colours of some points and the model's there."""
    local = (cloud.points[points] - pose[:3, 3]) @ pose[:3, :3]
    index, near = model.nearest(local, cloud.normals[points] @ pose[:3, :3], NEAR)
    if not near.any():
        return float("inf")
    off = difference(model.colors[index[near]], cloud.colors[points][near])
    # Mixed and mirrored colours must not decide: beyond a point all are equally wrong.
    return float(np.minimum(off, 9.0).mean() + 9.0 * (1 - near.mean()))
