"""Frames moved on to each other: what one view's calibration has wrong shows where it meets the others' points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from tamp.perception.estimation.fusion import Cloud, LevelFrame, fuse
from tamp.task.model import Table

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROUNDS = 4
REACH = 0.010
"""Points of two views farther apart than this are not the same [m]."""

FEWEST = 200
"""Views that share fewer points than this are left as they are."""

MOST = 4000
"""Points of a view that are looked at."""


def register(frames: Sequence[LevelFrame], table: Table) -> list[LevelFrame]:
    """Shift frames along the table and turn them about the vertical until their points agree with the others'.

    Point-to-plane ICP of each view against all others in turn; the mean shift of all is taken out again, since no view
    is known to be right. Height and tilt stay: the table has settled those.
    """
    clouds = [_thinned(fuse([frame], table)) for frame in frames]
    moves = [np.eye(4) for _ in frames]
    for _ in range(ROUNDS):
        placed = [_moved(cloud, T) for cloud, T in zip(clouds, moves, strict=True)]
        for i, cloud in enumerate(placed):
            others = [c for j, c in enumerate(placed) if j != i and len(c.points)]
            if others and len(cloud.points) >= FEWEST:
                step = _step(cloud, np.concatenate([c.points for c in others]), others)
                moves[i] = step @ moves[i]
                placed[i] = _moved(clouds[i], moves[i])
    middle = np.mean([T[:2, 3] for T in moves], axis=0)
    result = []
    for frame, T in zip(frames, moves, strict=True):
        T[:2, 3] -= middle
        result.append(replace(frame, T_world_camera=T @ frame.T_world_camera))
    return result


def _thinned(cloud: Cloud) -> Cloud:
    step = max(1, len(cloud.points) // MOST)
    return cloud.at(np.arange(0, len(cloud.points), step))


def _moved(cloud: Cloud, T: Array) -> Cloud:
    R = T[:3, :3]
    return replace(cloud, points=cloud.points @ R.T + T[:3, 3], normals=cloud.normals @ R.T)


def _step(cloud: Cloud, points: Array, others: Sequence[Cloud]) -> Array:
    """The motion (4, 4) of a cloud in the plane that brings it nearer to others' points."""
    normals = np.concatenate([c.normals for c in others])
    distance, index = cKDTree(points).query(cloud.points, distance_upper_bound=REACH)
    found = np.isfinite(distance)
    source, target, normal = cloud.points[found], points[index[found]], normals[index[found]]
    agree = np.einsum("ij,ij->i", cloud.normals[found], normal) > 0.8
    source, target, normal = source[agree], target[agree], normal[agree]
    if len(source) < FEWEST:
        return np.eye(4)
    center = source.mean(axis=0)
    gap = np.einsum("ij,ij->i", target - source, normal)
    arm = source - center
    rows = np.column_stack([arm[:, 0] * normal[:, 1] - arm[:, 1] * normal[:, 0], normal[:, 0], normal[:, 1]])
    weight = np.maximum(0.0, 1 - (gap / REACH) ** 2) ** 2
    # Surfaces that say nothing about a direction must not move the view along it.
    damping = np.diag([1e-4, 1e-2, 1e-2]) * len(source)
    yaw, x, y = np.linalg.solve(rows.T @ (rows * weight[:, None]) + damping, rows.T @ (weight * gap))
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:3, 3] = center - T[:3, :3] @ center + (x, y, 0.0)
    return T
