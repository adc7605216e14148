"""Whether what cameras see contradicts where objects are thought to be: a quick look that needs no perceiver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Frame
from tamp.perception.estimation.fusion import level
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.scene import objects_at, table_body
from tamp.perception.rendering.surface import Surface
from tamp.task.model import Table
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEP = 2
"""Every so many pixels are looked at."""

BEHIND = 0.012
"""A pixel sees through an object where it measures so much behind its surface, across that [m].

Along a ray that grazes a surface a little error goes far.
"""

NEARER = 0.003
"""Or, of what is flat, where it measures so much and is nearer to the table behind it than to the object [m]."""

FEWEST = 60
"""Fewer pixels say nothing."""

SHARE = 0.5
"""An object is absent where a larger share of its pixels sees through it."""


def absent(
    frames: Iterable[Frame],
    looks: Mapping[str, Surface],
    poses: Mapping[str, Pose],
    table: Table,
    renderer: str = "raycast",
) -> set[str]:
    """Objects that are not where they are thought to be.

    Args:
        frames: what was seen.
        looks: object -> what it looks like.
        poses: object -> where it is thought to be (world frame).
        table: the table top.
        renderer: "raycast" or "software".
    """
    bodies, top = objects_at(looks, poses), table_body(table)
    through, seen = np.zeros(len(bodies), dtype=np.int64), np.zeros(len(bodies), dtype=np.int64)
    opened = open_renderer(renderer)
    with opened([*bodies, top]) as scene, opened([top]) as bare:
        for frame in frames:
            view = frame.intrinsics.scaled(1 / STEP), level(frame, table).T_world_camera
            picture, empty = scene.picture(*view), bare.picture(*view)
            measured = frame.depth[::STEP, ::STEP]
            judged = _inner(picture.bodies) & (measured > 0) & ~frame.robot[::STEP, ::STEP]
            judged &= (picture.bodies >= 0) & (picture.bodies < len(bodies))
            # Where no table is behind, half of the way to it is no limit.
            halfway = np.where(empty.depth > 0, (empty.depth - picture.depth) / 2 * picture.slant, BEHIND)
            judged &= halfway >= NEARER
            shown = picture.bodies[judged]
            behind = ((measured - picture.depth) * picture.slant > np.minimum(BEHIND, halfway))[judged]
            seen += np.bincount(shown, minlength=len(bodies))
            through += np.bincount(shown[behind], minlength=len(bodies))
    return {
        body.name
        for body, count, gone in zip(bodies, seen, through, strict=True)
        if count >= FEWEST and gone > SHARE * count
    }


def _inner(bodies: NDArray[np.int16]) -> NDArray[np.bool_]:
    """Pixels whose neighbours show the same body."""
    inner = np.ones(bodies.shape, dtype=bool)
    for axis in (0, 1):
        for shift in (1, -1):
            inner &= np.roll(bodies, shift, axis) == bodies
    return inner
