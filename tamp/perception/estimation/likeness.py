"""Telling apart by colour the poses that a shape's symmetry makes alike."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.fit import polished
from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.models.color import difference
from tamp.perception.estimation.models.object_model import ObjectModel
from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST = 600
"""Points that are compared at each pose."""

FINALISTS = 10
"""Turns that are looked at closely: those that stand for all of a round shape are too far apart for small marks."""

FINER = np.radians([8.0, 4.0, 2.0])
"""By so much these are turned on, as long as that is better."""

NEAR = 0.010
"""A measured point takes its colour from the model's surface at most this far away [m]."""


def turned_by_color(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> Array:
    """The pose among those that the shape cannot tell from a given one whose colours fit best, shape (4, 4).

    A shape that is nearly symmetrical lies a little otherwise when it is turned: the best turns are fitted anew.

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
    first = np.argsort([mismatch(cloud, model, T, some) for T in poses], kind="stable")[:FINALISTS]
    finalists = [_turned_on(cloud, model, polished(cloud, model, poses[i], some), some) for i in first]
    return min(finalists, key=lambda found: found[1])[0]


def _turned_on(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> tuple[Array, float]:
    """A pose turned about the axes of a round shape until the colours fit best, and their mismatch there."""
    best, least = pose, mismatch(cloud, model, pose, points)
    for angle in FINER:
        turns = [model.about_center(rotation(axis, sign * angle)) for axis in model.round_axes for sign in (1.0, -1.0)]
        better = bool(turns)
        while better:
            tried = [best @ turn for turn in turns]
            costs = [mismatch(cloud, model, T, points) for T in tried]
            k = int(np.argmin(costs))
            better = costs[k] < least
            if better:
                best, least = tried[k], costs[k]
    return best, least


def mismatch(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> float:
    """Mean difference between the measured colours of some points and the model's there."""
    local = (cloud.points[points] - pose[:3, 3]) @ pose[:3, :3]
    index, near = model.nearest(local, cloud.normals[points] @ pose[:3, :3], NEAR)
    if not near.any():
        return float("inf")
    off = difference(model.colors[index[near]], cloud.colors[points][near])
    # Mixed and mirrored colours must not decide: beyond a point all are equally wrong.
    return float(np.minimum(off, 9.0).mean() + 9.0 * (1 - near.mean()))
