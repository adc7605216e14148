"""What is known of every cell of space over the table: which measured point is near, and what cameras saw through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.fusion import HIGH, OUTSIDE, VOXEL, Cloud, LevelFrame, smallest
from tamp.perception.estimation.matching import look_up_all
from tamp.task.model import Table

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

REACH = 4
"""Cells that a measured point is near to: 16 mm."""

BEHIND = 0.010
"""A cell is free where a camera measured more than this behind it [m]."""

MARGIN = 0.03
"""How far the volume reaches beyond the points [m]."""

COARSE = 0.02
"""Edge of the cells around the volume [m]."""


@dataclass(frozen=True, eq=False)
class Volume:
    """Cells of 4 mm around all points.

    Attributes:
        cloud: the points.
        origin: corner of the first cell, shape (3,) [m]; z is the table's top.
        nearest: index of the nearest point within 16 mm, -1 for none; int32 (x, y, z).
        free: whether a camera saw through the cell; bool (x, y, z).
        frames: what it was surveyed from.
        corner: of the first coarse cell around the volume, shape (3,) [m].
        hidden: whether nobody has seen into each coarse cell, bool (x, y, z); beyond them nothing is.
    """

    cloud: Cloud
    origin: Array
    nearest: NDArray[np.int32]
    free: NDArray[np.bool_]
    frames: tuple[LevelFrame, ...] = ()
    corner: Array = field(default_factory=lambda: np.zeros(3))
    hidden: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0, 0), dtype=np.bool_))

    def look_up(self, points: Array) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """For points (n, 3): the nearest measured point or -1, and whether the place is known to be empty.

        Under the table nothing can be; nor can it beside the volume, where no camera measured anything but some have
        looked. What reaches out of the pictures is not seen through there.
        """
        return look_up_all(points, *self.cells)

    def of_points(self, some: NDArray[np.int64]) -> Volume:
        """The same space with some of the measured points alone, by their indices; what was seen through stays so."""
        number = np.full(len(self.cloud.points) + 1, -1, dtype=np.int32)
        number[some] = np.arange(len(some), dtype=np.int32)
        return replace(self, cloud=self.cloud.at(some), nearest=np.asarray(number[self.nearest]))

    @property
    def cells(
        self,
    ) -> tuple[Array, float, NDArray[np.int32], NDArray[np.bool_], Array, float, NDArray[np.bool_]]:
        """What `matching` is told of the volume: origin, edge of a cell [m], `nearest`, `free`, and the same around."""
        return self.origin, VOXEL, self.nearest, self.free, self.corner, COARSE, self.hidden


def survey(
    frames: Sequence[LevelFrame],
    cloud: Cloud,
    within: tuple[Array, Array] | None = None,
    *,
    table: Table | None = None,
) -> Volume:
    """The volume around a cloud, as the frames saw it.

    Args:
        frames: what was seen.
        cloud: the points.
        within: least and greatest corner of what may be occupied, shape (3,) each; None is a little around the cloud.
        table: things on it may reach out of the volume to where nobody has looked; None: nothing does.
    """
    lower, upper = (cloud.points.min(axis=0) - MARGIN, cloud.points.max(axis=0) + MARGIN) if within is None else within
    lower = np.append(lower[:2], 0.0)
    shape = np.ceil((upper - lower) / VOXEL).astype(int)
    free = _free(frames, lower, shape, VOXEL)
    nearest = _nearest(cloud.points, lower, shape)
    empty = free & (nearest < 0) | _clearly(free, nearest, cloud, lower)
    volume = Volume(cloud, lower, nearest, empty, tuple(frames))
    return volume if table is None else _with_surroundings(volume, table)


def _with_surroundings(volume: Volume, table: Table) -> Volume:
    """A volume that knows where over the table nobody has looked."""
    middle, half = np.array(table.center), np.array(table.size) / 2 + OUTSIDE
    corner = np.append(middle - half, 0.0)
    shape = np.ceil((np.append(middle + half, HIGH) - corner) / COARSE).astype(int)
    return replace(volume, corner=corner, hidden=~_free(volume.frames, corner, shape, COARSE))


def _free(frames: Sequence[LevelFrame], lower: Array, shape: NDArray[np.int64], edge: float) -> NDArray[np.bool_]:
    """Cells that any frame has seen through."""
    free = np.zeros(tuple(shape), dtype=bool)
    for frame in frames:
        free |= _seen_through(frame, lower, shape, edge)
    return free


def _clearly(free: NDArray[np.bool_], nearest: NDArray[np.int32], cloud: Cloud, lower: Array) -> NDArray[np.bool_]:
    """Free cells near a point, but more than two cells away from it."""
    at = np.argwhere(free & (nearest >= 0))
    centers = lower + (at + 0.5) * VOXEL
    away = np.linalg.norm(centers - cloud.points[nearest[tuple(at.T)]], axis=1) > 2 * VOXEL
    found = np.zeros(free.shape, dtype=bool)
    found[tuple(at[away].T)] = True
    return found


def _seen_through(frame: LevelFrame, lower: Array, shape: NDArray[np.int64], edge: float) -> NDArray[np.bool_]:
    """Cells before what a frame measured."""
    k = frame.frame.intrinsics
    T = np.linalg.inv(frame.T_world_camera).astype(np.float32)
    # A cell's place in the picture is linear in its three indices.
    steps = T[:3, :3] * np.float32(edge)
    corner = T[:3, :3] @ (lower + edge / 2).astype(np.float32) + T[:3, 3]
    axes = [np.arange(n, dtype=np.float32) for n in shape]
    parts = [
        corner[i]
        + steps[i, 0] * axes[0][:, None, None]
        + steps[i, 1] * axes[1][None, :, None]
        + steps[i, 2] * axes[2][None, None, :]
        for i in range(3)
    ]
    z = parts[2]
    ahead = z > 0.05
    safe = np.where(ahead, z, np.float32(1))
    u = (parts[0] / safe * np.float32(k.fx) + np.float32(k.cx)).astype(np.int32)
    v = (parts[1] / safe * np.float32(k.fy) + np.float32(k.cy)).astype(np.int32)
    inside = ahead & (u >= 0) & (u < k.width) & (v >= 0) & (v < k.height)
    depth = smallest(frame.frame.depth, 1)
    measured = depth[np.where(inside, v, 0), np.where(inside, u, 0)]
    return np.asarray(inside & (measured - z > BEHIND))


def _nearest(points: Array, lower: Array, shape: NDArray[np.int64]) -> NDArray[np.int32]:
    """Each cell's nearest point: every point claims the cells around it, the far ones first."""
    span = np.arange(-REACH, REACH + 1)
    offsets = np.stack(np.meshgrid(span, span, span, indexing="ij"), axis=-1).reshape(-1, 3)
    distance = (offsets**2).sum(axis=1)
    offsets = offsets[distance <= REACH**2]
    offsets = offsets[np.argsort(-(offsets**2).sum(axis=1), kind="stable")]
    padded = np.full(tuple(shape + 2 * REACH), -1, dtype=np.int32)
    cells = np.floor((points - lower) / VOXEL).astype(np.int64) + REACH
    flat = np.ravel_multi_index(tuple(cells.T), padded.shape)
    strides = np.array([padded.shape[1] * padded.shape[2], padded.shape[2], 1])
    index = np.arange(len(points), dtype=np.int32)
    target = padded.reshape(-1)
    for offset in offsets @ strides:
        target[flat + offset] = index
    return padded[REACH:-REACH, REACH:-REACH, REACH:-REACH].copy()
