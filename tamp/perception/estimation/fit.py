"""How well poses of a model agree with what was measured, and moving them until they agree best; many at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.color import alike
from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.model import FINE, ObjectModel
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

BATCH = 4000
"""Poses scored at a time: what fits into a processor's cache."""


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
    scores = np.empty(len(poses))
    local = model.points[:points]
    for start in range(0, len(poses), BATCH):
        part = poses[start : start + BATCH].astype(np.float32)
        placed = np.einsum("nij,kj->nki", part[:, :3, :3], local.astype(np.float32)) + part[:, None, :3, 3]
        nearest, free = volume.look_up(placed)
        near = (nearest >= 0) & ~free
        offset = placed - volume.cloud.points.astype(np.float32)[np.maximum(nearest, 0)]
        close = np.einsum("nki,nki->nk", offset, offset) < 0.010**2
        scores[start : start + BATCH] = (near & close).mean(axis=1) - VIOLATION * free.mean(axis=1)
    return scores


def agreement(volume: Volume, model: ObjectModel, poses: Array, points: int = FINE) -> Agreement:
    """How much of a model's surface was measured where poses (n, 4, 4) put it, and how much was seen through."""
    hits, violations = np.empty(len(poses)), np.empty(len(poses))
    for start in range(0, len(poses), BATCH // 8):
        part = slice(start, start + BATCH // 8)
        match = _matched(volume, model, poses[part], points)
        color = alike(model.colors[:points], volume.cloud.colors[match.nearest])
        hits[part] = (match.near * color).mean(axis=1)
        violations[part] = match.free.mean(axis=1)
    return Agreement(hits, violations)


@dataclass(frozen=True, eq=False)
class _Match:
    """For each pose and model point, shape (n, k): the nearest measured point, and whether they belong together."""

    placed: Array
    nearest: NDArray[np.int32]
    near: NDArray[np.bool_]
    free: NDArray[np.bool_]
    gap: Array
    normals: Array


def _matched(volume: Volume, model: ObjectModel, poses: Array, points: int, reach: float = NEAR) -> _Match:
    R, t = poses[:, :3, :3], poses[:, :3, 3]
    placed = np.einsum("nij,kj->nki", R, model.points[:points]) + t[:, None]
    facing = np.einsum("nij,kj->nki", R, model.normals[:points])
    nearest, free = volume.look_up(placed)
    index = np.maximum(nearest, 0)
    normals = volume.cloud.normals[index]
    gap = np.einsum("nki,nki->nk", volume.cloud.points[index] - placed, normals)
    agree = np.einsum("nki,nki->nk", facing, normals) > FACING
    near = (nearest >= 0) & (np.abs(gap) < reach) & agree
    return _Match(placed, index, near, free & ~near, gap, normals)


def refine(volume: Volume, model: ObjectModel, poses: Array, rounds: int = 10, points: int = FINE) -> Array:
    """Poses moved onto the measured points, shape (n, 4, 4): point-to-plane ICP (Chen and Medioni, 1992), batched.

    What would be under the table is pushed up; the reach shrinks from round to round.
    """
    poses = poses.copy()
    for number in range(rounds):
        reach = max(0.004, 0.014 * 0.8**number)
        match = _matched(volume, model, poses, points, reach)
        center = poses[:, :3, 3]
        arm = match.placed - center[:, None]
        rows = np.concatenate([np.cross(arm, match.normals), match.normals], axis=2)
        weight = match.near * np.maximum(0.0, 1 - (match.gap / (1.5 * reach)) ** 2) ** 2
        under = match.placed[..., 2] < -0.0005
        floor = np.zeros_like(rows)
        floor[..., 0], floor[..., 1], floor[..., 5] = arm[..., 1], -arm[..., 0], 1.0
        A = np.einsum("nki,nkj,nk->nij", rows, rows, weight)
        A += np.einsum("nki,nkj,nk->nij", floor, floor, under.astype(float))
        b = np.einsum("nki,nk->ni", rows, weight * match.gap)
        b += np.einsum("nki,nk->ni", floor, np.where(under, -match.placed[..., 2], 0.0))
        size = model.diameter / 4
        damping = 0.02 * np.diag([size**2] * 3 + [1.0] * 3) * np.maximum(weight.sum(axis=1), 4.0)[:, None, None]
        step = np.linalg.solve(A + damping, b[..., None])[..., 0]
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


def polished(cloud: Cloud, model: ObjectModel, pose: Array, points: NDArray[np.int64], rounds: int = 12) -> Array:
    """A pose, shape (4, 4), moved until measured points lie on the model: point-to-plane ICP the other way round.

    What was measured of an object must all lie on it, whereas not all of its surface was measured: this comes last.

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
        damping = 0.001 * weight.sum() * np.diag([(model.diameter / 4) ** 2] * 3 + [1.0] * 3)
        step = np.linalg.solve((rows * weight[:, None]).T @ rows + damping, rows.T @ (weight * gap))
        moved = T[None]
        _move(moved, step[None])
        T = moved[0]
    return T


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
