"""Whether a symbolic goal holds, judged from final poses alone: on a region, on an object, in an object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.enclosure import lies_in, meet
from tamp.task.mesh.parts import parts
from tamp.task.model import In, On, Region, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.model import Shape
    from tamp.task.pose import Pose

    Array = NDArray[np.float64]
    Box = tuple[Array, Array]

REST_GAP = 0.01
"""How far above or inside its support the bottom of a resting object may be [m]."""


def holds(task: Task, name: str, goal: On | In, poses: Mapping[str, Pose]) -> bool:
    """Whether the object called `name` is on or in its target.

    On a region: the centre of its footprint lies in the region and it has not sunk below the table. On an object: that
    centre lies in the support's footprint, its bottom is between the support's bottom and top, and it would meet the
    support if it were a little lower: it is not merely beside it, in the corner of an L.
    In an object: `tamp.task.mesh.enclosure.lies_in`. Footprints are the axis-aligned extents of the object as it lies.

    Args:
        task: gives shapes and regions.
        name: the object.
        goal: what is asked.
        poses: object -> final pose in the world frame.
    """
    shape, T = task.object(name).shape, poses[name].matrix
    if isinstance(goal, In):
        return lies_in(shape, T, task.object(goal.target).shape, poses[goal.target].matrix)
    lower, upper = extent(shape, poses[name])
    center = (lower + upper) / 2
    region = next((r for r in task.regions if r.name == goal.target), None)
    if region is not None:
        return _in_rectangle(region, center) and bool(lower[2] >= -REST_GAP)
    support = task.object(goal.target).shape
    below, above = extent(support, poses[goal.target])
    over = bool((below[:2] <= center[:2]).all() and (center[:2] <= above[:2]).all())
    if not over or not below[2] - REST_GAP / 10 <= lower[2] <= above[2] + REST_GAP:
        return False
    lowered = T.copy()
    lowered[2, 3] -= REST_GAP
    return meet(shape, lowered, support, poses[goal.target].matrix)


def extent(shape: Shape, pose: Pose) -> Box:
    """Lower and upper corner of the shape as it lies, in the world frame, each of shape (3,) [m]."""
    T = pose.matrix
    points = np.concatenate([part.vertices for part in parts(shape)]) @ T[:3, :3].T + T[:3, 3]
    return points.min(axis=0), points.max(axis=0)


def _in_rectangle(region: Region, point: Array) -> bool:
    return all(
        abs(value - center) <= size / 2
        for value, center, size in zip(point[:2], region.center, region.size, strict=True)
    )
