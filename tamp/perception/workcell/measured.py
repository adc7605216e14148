"""What cameras that stand have measured is in the arm's way, whether or not anybody knows yet what it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

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

LOW = 0.03
"""Lower columns are in nobody's way [m]."""

CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


def with_measured(world: World, poses: Mapping[str, Pose], frames: Sequence[Frame]) -> tuple[World, Mapping[str, Pose]]:
    """A world and scene in which what frames measured over the table is an obstacle, besides what is known.

    Args:
        world: robot, table and objects.
        poses: object -> where it is thought to be (world frame).
        frames: of cameras that stand; the arm in them is none of it.
    """
    columns = _columns(np.concatenate([np.empty((0, 3)), *(_points(frame, world) for frame in frames)]))
    if not columns:
        return world, poses
    geometries = {**world.geometries, MEASURED: geometry_of(columns)}
    return World(world.robot, geometries, world.table), {**poses, MEASURED: Pose()}


def _points(frame: Frame, world: World) -> Array:
    return fuse([level(frame, world.table)], world.table).points


def _columns(points: Array) -> list[Part]:
    """Boxes from the table to the highest point in each cell."""
    cells, cell = np.unique(np.floor(points[:, :2] / CELL).astype(np.int64), axis=0, return_inverse=True)
    heights = np.zeros(len(cells))
    np.maximum.at(heights, cell.reshape(-1), points[:, 2])
    return [
        convex_hull(CORNERS * (CELL, CELL, height) + (CELL * x, CELL * y, 0.0))
        for (x, y), height in zip(cells.tolist(), heights.tolist(), strict=True)
        if height > LOW
    ]
