"""What cameras have measured is in the arm's way, whether or not anybody knows yet what it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.belief.next_view import GAP, measured_depth, seen_into
from tamp.perception.cameras.camera import Frame
from tamp.perception.estimation.fusion import fuse, level
from tamp.task import Pose
from tamp.task.mesh.parts import Part, convex_hull
from tamp.world.geometry.object_geometry import geometry_of
from tamp.world.world import World

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MEASURED = "measured by cameras"
"""What the obstacle is called among the objects."""

CELL = 0.02
"""Edge of the columns that measured points become [m]."""

HIGH = 0.3
"""What is measured reaches so much higher at most than it was seen to [m]."""

LOW = 0.03
"""Lower columns are in nobody's way [m]."""

CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


def with_measured(
    world: World, poses: Mapping[str, Pose], frames: Sequence[Frame], *, near: bool = False
) -> tuple[World, Mapping[str, Pose]]:
    """A world and scene in which what frames measured over the table is an obstacle, besides what is known.

    Args:
        world: robot, table and objects.
        poses: object -> where it is thought to be (world frame).
        frames: of what stood still; the arm in them is none of it.
        near: whether they were taken from so near that what is measured may be higher than they show: it then reaches
            up to where one of them has seen that nothing is.
    """
    measured = np.concatenate([np.empty((0, 3)), *(_points(frame, world) for frame in frames)])
    columns = _columns(measured, frames if near else ())
    if not columns:
        return world, poses
    geometries = {**world.geometries, MEASURED: geometry_of(columns)}
    return World(world.robot, geometries, world.table), {**poses, MEASURED: Pose()}


def _points(frame: Frame, world: World) -> Array:
    return fuse([level(frame, world.table)], world.table).points


def _columns(points: Array, near: Sequence[Frame]) -> list[Part]:
    """Boxes from the table to the highest point in each cell, or to where frames show that nothing is."""
    cells, cell = np.unique(np.floor(points[:, :2] / CELL).astype(np.int64), axis=0, return_inverse=True)
    heights = np.zeros(len(cells))
    np.maximum.at(heights, cell.reshape(-1), points[:, 2])
    if near:
        heights = _at_most(CELL * (cells.astype(np.float64) + 0.5), heights, near)
    return [
        convex_hull(CORNERS * (CELL, CELL, height) + (CELL * x, CELL * y, 0.0))
        for (x, y), height in zip(cells.tolist(), heights.tolist(), strict=True)
        if height > LOW
    ]


def _at_most(middles: Array, heights: Array, frames: Sequence[Frame]) -> Array:
    """How high columns (n, 2) may be that are at least so high: up to the first place that a frame has seen into."""
    steps = np.arange(CELL, HIGH, CELL)
    levels = heights[:, None] + steps
    places = np.concatenate([np.repeat(middles, len(steps), axis=0), levels.reshape(-1, 1)], axis=1)
    empty = np.zeros(len(places), dtype=bool)
    for frame in frames:
        empty |= seen_into(frame.intrinsics, frame.T_world_camera, measured_depth(frame), places, GAP)
    # The last level counts as empty: nothing is as high.
    first = np.column_stack([empty.reshape(levels.shape)[:, :-1], np.ones(len(levels), dtype=bool)]).argmax(axis=1)
    return np.asarray(heights + CELL * first, dtype=np.float64)
