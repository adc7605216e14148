"""How likely measured points are if they lie on a model at a pose, and which of its nearly symmetrical turns that is.

Few things are as symmetrical as they look: a can has a lid, a bowl a dent, a label a front. Over the points of a whole
object that shows, where the residuals of any one of them would say nothing.
"""

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

PRECISION = 0.0012
"""Standard deviation of a fused point from the surface that it lies on [m]."""

MOST = 4.5
"""What a point costs at most for its place, and for its colour: three standard deviations."""

FIRST, CLOSELY = 600, 2500
"""Points, about, that all turns are judged by, and the finalists."""

FINALISTS = 10
"""Turns that are looked at closely: those that stand for all of a round shape are too far apart for small marks."""

FITTED = 80
"""More turns than this are not fitted before they are judged: they are a ball's."""

FINER = np.radians([8.0, 4.0, 2.0])
"""By so much a pose is turned on, as long as that is better."""

NOISE = 0.005
"""A turn that is likelier by less than this, in the likelihood's logarithm a point, is no better."""


def misfit(cloud: Cloud, model: ObjectModel, pose: Array, own: NDArray[np.int64]) -> float:
    """Negative logarithm of how likely points are, in place and colour, if they lie on a model at a pose."""
    return float(misfits(cloud, model, pose[None], own)[0])


def misfits(
    cloud: Cloud, model: ObjectModel, poses: Array, own: NDArray[np.int64], precision: float = PRECISION
) -> Array:
    """The `misfit` of each of many poses (n, 4, 4), for points of such a standard deviation [m], shape (n,)."""
    R = poses[:, :3, :3]
    local = np.einsum("npj,nji->npi", cloud.points[own] - poses[:, None, :3, 3], R).reshape(-1, 3)
    facing = np.einsum("pj,nji->npi", cloud.normals[own], R).reshape(-1, 3)
    index, near = model.nearest(local, facing, 0.012 + model.spacing)
    gap = np.einsum("ij,ij->i", local - model.points[index], model.normals[index])
    cost = np.minimum((gap / precision) ** 2 / 2, MOST).reshape(len(poses), -1)
    colors = model.colors[index].reshape(*cost.shape, 3)
    cost += np.minimum(difference(colors, cloud.colors[own]) / 2, MOST)
    total: Array = np.where(near.reshape(cost.shape), cost, 2 * MOST).sum(axis=1)
    return total


def fitted_turns(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> Array:
    """The poses that a shape's symmetries, which hold nearly, make alike, each fitted to points anew, (n, 4, 4).

    A shape that is nearly symmetrical lies a little otherwise when it is turned.
    """
    some = points[:: max(1, len(points) // FIRST)]
    return np.stack([polished(cloud, model, T, some) for T in pose @ model.symmetries])


def likeliest_turn(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> Array:
    """The likeliest of the poses that a shape's symmetries, which hold nearly, make alike, shape (4, 4).

    Args:
        cloud: what was measured.
        model: the object.
        pose: where it is but for its symmetries.
        points: indices of the points that belong to it.
    """
    poses = pose @ model.symmetries
    if len(poses) == 1 or len(points) < 10:
        return pose
    few, many = (points[:: max(1, len(points) // count)] for count in (FIRST, CLOSELY))
    if len(poses) <= FITTED:
        poses = fitted_turns(cloud, model, pose, points)
    first = np.argsort([misfit(cloud, model, T, few) for T in poses], kind="stable")[:FINALISTS]
    finalists = [likeliest_near(cloud, model, polished(cloud, model, poses[i], many), many) for i in first]
    return min(finalists, key=lambda found: found[1])[0]


def likeliest_near(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64]) -> tuple[Array, float]:
    """A pose turned about the model's middle until points are likeliest, and its misfit there.

    What is nearly round fits hardly worse however it is turned, so that a fit by shape turns it as noise has it; only
    its colours say how far. What has none stays as it is.
    """
    best, least = pose, misfit(cloud, model, pose, points)
    for angle in FINER if model.colored else ():
        turns = [model.about_center(rotation(axis, sign * angle)) for axis in np.eye(3) for sign in (1.0, -1.0)]
        better = True
        while better:
            tried = [best @ turn for turn in turns]
            costs = [misfit(cloud, model, T, points) for T in tried]
            k = int(np.argmin(costs))
            better = costs[k] < least - NOISE * len(points)
            if better:
                best, least = tried[k], costs[k]
    return best, least
