"""How well poses of a model agree with what was measured, and moving them until they agree best; many at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.matching import correspondences, nearness, normal_equations
from tamp.perception.estimation.models.color import alike
from tamp.perception.estimation.models.object_model import FINE, ObjectModel
from tamp.perception.estimation.volume import Volume

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

NEAR = 0.005
"""A model's point is hit where a measured surface passes this near [m]."""

FACING = 0.5
"""Least cosine between the normals of model and measurement."""

VIOLATION = 1.5
"""What a point in free space costs, in hits."""

NEARLY = 0.010
"""At a glance, a measured point this near is enough [m]."""

UNDER = -0.0005
"""What lies lower than this is under the table [m]."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """Shares of a model's points, one for each pose, shape (n,)."""

    hits: Array
    violations: Array

    @property
    def score(self) -> Array:
        """Hits less what violations cost."""
        score: Array = self.hits - VIOLATION * self.violations
        return score


def glance(volume: Volume, model: ObjectModel, poses: Array, points: int) -> Array:
    """A quick score of many poses, shape (n, 4, 4): nearness alone."""
    hits, violations = nearness(poses, model.points[:points], volume.cloud.points, *volume.cells, NEARLY)
    scores: Array = hits - VIOLATION * violations
    return scores


def agreement(volume: Volume, model: ObjectModel, poses: Array, points: int = FINE) -> Agreement:
    """How much of a model's surface was measured where poses (n, 4, 4) put it, and how much was seen through."""
    matched, violations = _matched(volume, model, poses, points, NEAR)
    pose, point = np.nonzero(matched >= 0)
    color = alike(model.colors[point], volume.cloud.colors[matched[pose, point]])
    return Agreement(np.bincount(pose, color, len(poses)) / points, violations)


def _matched(
    volume: Volume, model: ObjectModel, poses: Array, points: int, reach: float
) -> tuple[NDArray[np.int64], Array]:
    cloud = volume.cloud
    own, facing = model.points[:points], model.normals[:points]
    return correspondences(poses, own, facing, cloud.points, cloud.normals, *volume.cells, reach, FACING)


def refine(volume: Volume, model: ObjectModel, poses: Array, rounds: int = 10, points: int = FINE) -> Array:
    """Poses moved onto the measured points, shape (n, 4, 4): point-to-plane ICP (Chen and Medioni, 1992), batched.

    What would be under the table is pushed up; the reach shrinks from round to round.
    """
    poses, cloud, own = poses.copy(), volume.cloud, model.points[:points]
    stiffness = 0.02 * np.diag([(model.diameter / 4) ** 2] * 3 + [1.0] * 3)
    for number in range(rounds):
        reach = max(0.004, 0.014 * 0.8**number)
        matched, _ = _matched(volume, model, poses, points, reach)
        A, b, weight = normal_equations(poses, own, matched, cloud.points, cloud.normals, reach, UNDER)
        damped = A + stiffness * np.maximum(weight, 4.0)[:, None, None]
        step = np.asarray(np.linalg.solve(damped, b[..., None])[..., 0], dtype=np.float64)
        _move(poses, step)
    return poses


def _move(poses: Array, step: Array) -> None:
    """Turn poses about their origins by rotation vectors and shift them, in place; step is (n, 6)."""
    angle = np.linalg.norm(step[:, :3], axis=1)
    x, y, z = (step[:, :3] / np.maximum(angle, 1e-12)[:, None]).T
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    angle = np.minimum(angle, 0.3)[:, None, None]
    R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    poses[:, :3, :3] = R @ poses[:, :3, :3]
    poses[:, :3, 3] += step[:, 3:]


def turned_about_middle(model: ObjectModel, poses: Array, turns: Array) -> Array:
    """Poses (n, 4, 4) turned about the model's middle by rotation vectors, shape (n, 3), by 0.3 rad at most."""
    middles = poses[:, :3, :3] @ model.center + poses[:, :3, 3]
    moved = poses.copy()
    _move(moved, np.hstack([turns, np.zeros_like(turns)]))
    moved[:, :3, 3] = middles - moved[:, :3, :3] @ model.center
    return moved


def polished(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64], rounds: int = 12) -> Array:
    """A pose, shape (4, 4), moved until measured points lie on the model: point-to-plane ICP the other way round.

    What was measured of an object must all lie on it, whereas not all of its surface was measured: this comes last.
    Where the points leave a motion free, as the roll of what is round, the pose stays near what it was.

    Args:
        cloud: what was measured.
        model: the object.
        pose: where it is, nearly.
        points: indices of the points that belong to it.
        rounds: how often points and surface are matched anew.
    """
    T = pose.copy()
    for number in range(rounds):
        R, t = T[:3, :3], T[:3, 3]
        index, found = model.nearest((cloud.points[points] - t) @ R, cloud.normals[points] @ R, 0.012 + model.spacing)
        measured = cloud.points[points[found]]
        normals = model.normals[index[found]] @ R.T
        gap = np.einsum("ij,ij->i", measured - model.points[index[found]] @ R.T - t, normals)
        reach = max(0.003, 0.008 * 0.8**number)
        weight = np.maximum(0.0, 1 - (gap / (2 * reach)) ** 2) ** 2
        if weight.sum() < 12:
            return pose
        rows = np.column_stack([np.cross(measured - t, normals), normals])
        prior = 0.001 * weight.sum() * np.diag([(model.diameter / 4) ** 2] * 3 + [1.0] * 3)
        pull = rows.T @ (weight * gap) - prior @ _displacement(pose, T)
        step = np.linalg.solve((rows * weight[:, None]).T @ rows + prior, pull)
        moved = T[None]
        _move(moved, step[None])
        T = moved[0]
    return T


def _displacement(before: Array, after: Array) -> Array:
    """Rotation vector, for turns below a quarter, and shift from one pose (4, 4) to another, shape (6,)."""
    R = after[:3, :3] @ before[:3, :3].T
    turn = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return np.concatenate([turn, after[:3, 3] - before[:3, 3]])


def explained(cloud: Cloud, model: ObjectModel, pose: Array) -> tuple[NDArray[np.int64], Array]:
    """Indices of the measured points that a pose of the model explains, and how well, 0..1."""
    R, t = pose[:3, :3], pose[:3, 3]
    center = R @ model.center + t
    close = np.flatnonzero(((cloud.points - center) ** 2).sum(axis=1) < (model.diameter / 2 + 0.01) ** 2)
    local = (cloud.points[close] - t) @ R
    index, found = model.nearest(local, cloud.normals[close] @ R, 0.010 + 1.2 * model.spacing)
    close, local, index = close[found], local[found], index[found]
    normals = model.normals[index]
    gap = np.abs(np.einsum("ij,ij->i", local - model.points[index], normals))
    agree = np.einsum("ij,ij->i", cloud.normals[close] @ R, normals) > 0.3
    kept = agree & (gap < 0.007)
    close, gap, index = close[kept], gap[kept], index[kept]
    weight = alike(model.colors[index], cloud.colors[close]) * np.where(gap < 0.004, 1.0, 1 - (gap - 0.004) / 0.003)
    return close, weight


def gaps(cloud: Cloud, model: ObjectModel, pose: Array) -> Array:
    """How far each measured point is from the surface of a pose of the model, infinite where not near it, (n,) [m]."""
    found: Array = np.full(len(cloud.points), np.inf)
    close = np.flatnonzero(
        ((cloud.points - pose[:3, :3] @ model.center - pose[:3, 3]) ** 2).sum(axis=1) < (model.diameter / 2 + 0.01) ** 2
    )
    local = (cloud.points[close] - pose[:3, 3]) @ pose[:3, :3]
    index, near = model.nearest(local, cloud.normals[close] @ pose[:3, :3], 0.010 + 1.2 * model.spacing)
    gap = np.abs(np.einsum("ij,ij->i", local - model.points[index], model.normals[index]))
    found[close[near]] = gap[near]
    return found
