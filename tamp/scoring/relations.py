"""Whether a symbolic goal holds, judged from final poses alone: on a region, on an object, in an object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import bounds, parts
from tamp.task.model import In, On, Region, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.model import Shape
    from tamp.task.pose import Pose

    Box = tuple[NDArray[np.float64], NDArray[np.float64]]

REST_GAP = 0.01
"""How far above or inside its support the bottom of a resting object may be [m]."""


def holds(task: Task, name: str, goal: On | In, poses: Mapping[str, Pose]) -> bool:
    """Whether the object called `name` is on or in its target.

    On a region: the centre of its footprint lies in the region and it has not sunk below the table. On an object: that
    centre lies in the support's footprint, and its bottom is between the support's bottom and top.
    In an object: the centre of its bounding box lies within the container's bounds. Footprints are the axis-aligned
    extents of the object as it lies.

    Args:
        task: gives shapes and regions.
        name: the object.
        goal: what is asked.
        poses: object -> final pose in the world frame.
    """
    lower, upper = extent(task.object(name).shape, poses[name])
    center = (lower + upper) / 2
    if isinstance(goal, In):
        return _inside(task.object(goal.target).shape, poses[goal.target], center)
    region = next((r for r in task.regions if r.name == goal.target), None)
    if region is not None:
        return _in_rectangle(region, center) and bool(lower[2] >= -REST_GAP)
    below, above = extent(task.object(goal.target).shape, poses[goal.target])
    over = bool((below[:2] <= center[:2]).all() and (center[:2] <= above[:2]).all())
    return over and bool(below[2] - REST_GAP / 10 <= lower[2] <= above[2] + REST_GAP)


def extent(shape: Shape, pose: Pose) -> Box:
    """Lower and upper corner of the shape as it lies, in the world frame, each of shape (3,) [m]."""
    T = pose.matrix
    points = np.concatenate([part.vertices for part in parts(shape)]) @ T[:3, :3].T + T[:3, 3]
    return points.min(axis=0), points.max(axis=0)


def _inside(container: Shape, pose: Pose, point: NDArray[np.float64]) -> bool:
    T = pose.matrix
    local = T[:3, :3].T @ (point - T[:3, 3])
    lower, upper = bounds(container)
    return bool((lower <= local).all() and (local <= upper).all())


def _in_rectangle(region: Region, point: NDArray[np.float64]) -> bool:
    return all(
        abs(value - center) <= size / 2
        for value, center, size in zip(point[:2], region.center, region.size, strict=True)
    )
