"""How an object lies between the fingers that hold it: sought around where it should be, as far as pads let it move."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.candidates import fitted
from tamp.perception.estimation.models.object_model import ObjectModel
from tamp.perception.estimation.tracking.nearby import best_of, unexplained
from tamp.task.model import Table
from tamp.task.pose import Pose
from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SWINGS = np.linspace(-1.5, 1.5, 13)
"""Turns about the line between the pads that are tried, as far as things hang down [rad]."""

TILT, SLIDE = 0.35, 0.015
"""Turns about the other axes, and shifts along the pads, that are tried [rad], [m]."""

BETWEEN = 0.025
"""The middle of the pads is at most this far from the surface of what they hold [m]: they are that wide."""


def estimate_held(
    frames: Sequence[Frame],
    models: Mapping[str, ObjectModel],
    poses: Mapping[str, Pose],
    held: str,
    tool: Pose,
    axis: Sequence[float],
    table: Table,
) -> Estimate:
    """Where a held object is.

    Args:
        frames: pictures taken while the arm stands still.
        models: object -> model.
        poses: object -> where it is thought to be (world frame), the held one as if it had not moved in the hand.
        held: the object in the hand.
        tool: T_world_tool.
        axis: closing direction of the fingers in the tool frame, a unit vector.
        table: the table top.

    Returns:
        Its pose in the world frame, turned as its symmetries allow; None where too little of it is seen to tell. What
        is found elsewhere than expected is trusted by how much more it explains than staying there would.
    """
    model, hand, expected = models[held], tool.matrix, poses[held].matrix
    grip, placed = np.array(tool.xyz), models[held].points @ expected[:3, :3].T + expected[:3, 3]
    reach = float(np.linalg.norm(placed - grip, axis=1).max()) + SLIDE
    volume = unexplained(frames, models, poses, held, (grip, reach), table)
    if volume is None:
        return Estimate(None, 0.0)
    tried = np.stack([hand @ motion @ np.linalg.inv(hand) @ expected for motion in _motions(np.array(axis))])
    found = [c for c in fitted(volume, model, tried) if _between_pads(model, c.pose, tool)]
    best = best_of(volume, model, found, expected)
    if best.pose is None:
        return best
    centered = _centered(best.pose.matrix, expected, hand, np.array(axis))
    return Estimate(Pose.from_matrix(centered), best.confidence)


def _centered(pose: Array, expected: Array, hand: Array, axis: Array) -> Array:
    """A pose shifted along the closing axis until what is meant to be in the middle of the pads is: they centre it."""
    grip, closing = hand[:3, 3], hand[:3, :3] @ axis
    middle = pose @ np.linalg.inv(expected) @ np.append(grip, 1.0)
    centered = pose.copy()
    centered[:3, 3] -= closing * (closing @ (middle[:3] - grip))
    return centered


def _motions(axis: Array) -> Iterator[Array]:
    """What pads leave an object free to do, in the tool frame, shape (4, 4) each: swing, tilt and slide."""
    across = np.linalg.svd(axis[None])[2][1:]
    turns = [(axis, angle) for angle in SWINGS] + [(other, s * TILT) for other in across for s in (-1.0, 1.0)]
    for about, angle in turns:
        T = np.eye(4)
        T[:3, :3] = rotation(about, angle)
        yield T
    for along, s in itertools.product(across, (-SLIDE, SLIDE)):
        T = np.eye(4)
        T[:3, 3] = s * along
        yield T


def _between_pads(model: ObjectModel, pose: Array, tool: Pose) -> bool:
    grip = pose[:3, :3].T @ (np.array(tool.xyz) - pose[:3, 3])
    return bool(model.tree.query(grip)[0] < BETWEEN + model.spacing)
