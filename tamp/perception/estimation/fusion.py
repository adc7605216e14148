"""One cloud of oriented, coloured points from all frames, levelled by the table that every view sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tamp.perception.cameras.camera import Frame
from tamp.task.model import Table
from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

VOXEL = 0.004
"""Edge of the cells that points are fused in [m]."""

LOW = 0.004
"""What is lower over the table counts as the table [m]."""

HIGH = 0.6
"""Nothing higher is looked at [m]."""

OUTSIDE = 0.06
"""How far beside the table things may hang [m]."""

PIXELS = 2
"""Fewer pixels in a cell are no point."""

NEIGHBOURS = 18
"""Points that a normal is fitted to."""

LEFT = 0.3
"""A point that is explained less well than this is left."""

FEWEST = 25
"""Fewer points than this are no sight of a surface; of an object, unless they are a fifth of its cells."""

BESIDE = 2 * VOXEL
"""Points of one surface have neighbours within this [m]."""

FRINGE = 4 * VOXEL
"""What cameras smear beyond the edges of what they see is within this of it [m]."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points over the table in the world frame.

    Attributes:
        points, normals: shape (n, 3); normals towards the cameras that saw them.
        colors: shape (n, 3), 0..1.
        instances: index of the object that most pixels of a point showed, -1 for none; None without masks.
    """

    points: Array
    normals: Array
    colors: Array
    instances: NDArray[np.int64] | None = None

    def at(self, index: NDArray[np.bool_] | NDArray[np.int64]) -> Cloud:
        """Some of the points."""
        labels = None if self.instances is None else self.instances[index]
        return Cloud(self.points[index], self.normals[index], self.colors[index], labels)


@dataclass(frozen=True, eq=False)
class LevelFrame:
    """A frame whose pose was mended.

    Attributes:
        frame: the frame.
        T_world_camera: its pose with the table level at z = 0, shape (4, 4).
    """

    frame: Frame
    T_world_camera: Array


@dataclass(frozen=True, eq=False)
class Left:
    """Measured surfaces that no estimate explains, but for the fringes of what estimates explain.

    Attributes:
        points: shape (n, 3) [m].
    """

    points: Array

    @staticmethod
    def of(cloud: Cloud, covered: Array) -> Left:
        """What is left of a cloud whose points are explained so well each, 0..1, shape (n,)."""
        left = cloud.points[covered < LEFT]
        explained = cloud.points[covered >= LEFT]
        if not len(left) or not len(explained):
            return Left(left)
        pairs = cKDTree(left).query_pairs(BESIDE, output_type="ndarray")
        links = coo_array((np.ones(len(pairs), np.bool_), pairs.T), shape=(len(left), len(left)))
        count, surface = connected_components(links, directed=False)
        beyond = cKDTree(explained).query(left, distance_upper_bound=FRINGE)[0] > FRINGE
        return Left(left[np.bincount(surface, beyond, count)[surface] >= FEWEST])

    def goes_on(self, points: Array) -> float:
        """Along how much of the border of an estimate's points, shape (n, 3), such a surface lies beside them.

        As a share of the border that so many points have in a square; a jagged one has more.
        """
        if not len(points) or not len(self.points):
            return 0.0
        beside = cKDTree(self.points).query(points, distance_upper_bound=BESIDE)[0] <= BESIDE
        return float(beside.sum() / (4 * np.sqrt(len(points))))


def level(frame: Frame, table: Table) -> LevelFrame:
    """Turn and lift a frame so that the table it sees lies at z = 0; one that sees too little stays as it is."""
    T = frame.T_world_camera
    step = 4
    depth = np.where(frame.robot, np.float32(0), frame.depth)[::step, ::step]
    local = frame.intrinsics.points_every(depth, step)[depth > 0]
    points = local @ T[:3, :3].T + T[:3, 3]
    near = _over(points, table, -0.02) & (np.abs(points[:, 2]) < 0.025)
    points = points[near]
    band = 0.02
    for _ in range(6):
        if len(points) < 300:
            return LevelFrame(frame, T)
        A = np.column_stack([points[:, :2], np.ones(len(points))])
        plane = np.linalg.lstsq(A, points[:, 2], rcond=None)[0]
        residual = points[:, 2] - A @ plane
        band = max(0.004, 0.6 * band)
        points = points[np.abs(residual) < band]
    normal = np.array([-plane[0], -plane[1], 1.0])
    normal /= np.linalg.norm(normal)
    axis = np.cross(normal, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    R = rotation(axis / sine, float(np.arcsin(sine))) if sine > 1e-9 else np.eye(3)
    foot = np.array([0.0, 0.0, plane[2]])
    E = np.eye(4)
    E[:3, :3], E[:3, 3] = R, -R @ foot
    return LevelFrame(frame, E @ T)


def _over(points: Array, table: Table, margin: float) -> NDArray[np.bool_]:
    """Which points are over the table, or at most `margin` beside it [m]."""
    return np.asarray(
        (np.abs(points[:, :2] - table.center) < np.array(table.size) / 2 + margin).all(axis=1), dtype=np.bool_
    )


@dataclass(frozen=True, eq=False)
class _Pixels:
    points: Array
    colors: Array
    weights: Array
    instances: NDArray[np.int64]
    eyes: Array


def fuse(frames: Sequence[LevelFrame], table: Table) -> Cloud:
    """The points of all frames that lie over the table, one for each cell of 4 mm.

    A pixel's weight is what its sensor's precision is worth: errors grow with the square of the distance.
    """
    seen = [_pixels(frame, table) for frame in frames]
    points, colors, weights, instances, eyes = (
        np.concatenate([getattr(s, name) for s in seen])
        for name in ("points", "colors", "weights", "instances", "eyes")
    )
    if len(points) < NEIGHBOURS:
        return _nothing(_masked(frames))
    cells = np.floor(points / VOXEL).astype(np.int64)
    cells -= cells.min(axis=0)
    shape = cells.max(axis=0) + 1
    _, cell, count = np.unique(
        np.ravel_multi_index(tuple(cells.T), tuple(shape)), return_inverse=True, return_counts=True
    )
    kept = count >= PIXELS
    total = np.bincount(cell, weights)

    def mean(values: Array) -> Array:
        sums = [np.bincount(cell, weights * column) / total for column in values.T]
        return np.stack(sums, axis=1)[kept]

    labels = _most_common(cell, instances, len(count))[kept] if _masked(frames) else None
    fused = mean(points)
    if len(fused) < NEIGHBOURS:
        return _nothing(_masked(frames))
    return _lone_removed(Cloud(fused, _normals(fused, mean(eyes)), mean(colors), labels))


def _nothing(masked: bool) -> Cloud:
    none = np.empty((0, 3))
    return Cloud(none, none, none, np.empty(0, np.int64) if masked else None)


def _masked(frames: Sequence[LevelFrame]) -> bool:
    return all(f.frame.instances is not None for f in frames)


def _pixels(level_frame: LevelFrame, table: Table) -> _Pixels:
    """Every second pixel of what lies over the table, without those that fly between two surfaces."""
    frame, T = level_frame.frame, level_frame.T_world_camera
    near = float(np.median(frame.depth[frame.depth > 0])) if (frame.depth > 0).any() else 1.0
    step = 1 if near > 0.9 else 2
    depth = np.where(frame.robot | _flying(frame.depth, step), np.float32(0), frame.depth)[::step, ::step]
    rows, columns = np.nonzero(depth)
    local = frame.intrinsics.points_every(depth, step)[rows, columns].astype(np.float64)
    points = local @ T[:3, :3].T + T[:3, 3]
    kept = _over(points, table, OUTSIDE) & (points[:, 2] > LOW) & (points[:, 2] < HIGH)
    points, rows, columns = points[kept], rows[kept] * step, columns[kept] * step
    masks = frame.instances
    labels = np.full(len(points), -1) if masks is None else masks[rows, columns].astype(np.int64)
    weights = 1 / np.maximum(frame.depth[rows, columns].astype(np.float64), 0.2) ** 4
    eyes = T[:3, 3] - points
    eyes /= np.linalg.norm(eyes, axis=1)[:, None]
    return _Pixels(points, frame.color[rows, columns] / 255.0, weights, labels, eyes)


def _flying(depth: NDArray[np.float32], step: int) -> NDArray[np.bool_]:
    """Pixels with too few neighbours at about their depth."""
    alike = np.zeros(depth.shape, dtype=np.int8)
    band = np.float32(0.006) + np.float32(0.004) * depth
    for dv, du in ((0, step), (0, -step), (step, 0), (-step, 0)):
        alike += np.abs(np.roll(depth, (dv, du), axis=(0, 1)) - depth) < band
    return alike < 2


def _most_common(cell: NDArray[np.int64], labels: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """For each cell the label that most of its pixels have; pixels of no object count too."""
    kinds = int(labels.max()) + 2
    votes = np.bincount(cell * kinds + labels + 1, minlength=count * kinds).reshape(count, kinds)
    return np.asarray(votes.argmax(axis=1) - 1, dtype=np.int64)


def _normals(points: Array, eyes: Array) -> Array:
    """Normals of the planes through each point's neighbours, towards the cameras."""
    tree = cKDTree(points)
    k = min(NEIGHBOURS, len(points))
    distance, index = tree.query(points, k=k, distance_upper_bound=4 * VOXEL)
    index = np.where(np.isfinite(distance), index, np.arange(len(points))[:, None]).reshape(len(points), k)
    around = points[index]
    centred = around - around.mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred))
    normals: Array = vectors[:, :, 0] * np.where(np.einsum("ni,ni->n", vectors[:, :, 0], eyes) < 0, -1, 1)[:, None]
    return normals


def _lone_removed(cloud: Cloud) -> Cloud:
    """Without points that have fewer than four others within 1 cm: what flew."""
    tree = cKDTree(cloud.points)
    distance, _ = tree.query(cloud.points, k=min(5, len(cloud.points)))
    return cloud.at(np.asarray(distance[:, -1] < 0.010))


def smallest(depth: NDArray[np.float32], pixels: int) -> NDArray[np.float32]:
    """The least depth within `pixels` of each; where one is missing, none."""
    return np.asarray(ndimage.minimum_filter(depth, size=2 * pixels + 1))
