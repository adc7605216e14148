"""The hand as a few boxes in the tool frame: coarse, but thousands of grasps are sieved with it at once."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.robot.hand import hand_points

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.robot.model import RobotModel

SLICES = 2  # boxes along the approach direction that a link is cut into


@dataclass(frozen=True, eq=False)
class HandBoxes:
    """Boxes in the tool frame: the palm's, then the fingers' with the pads touching each other.

    Attributes:
        lower, upper: corners, shape (n, 3) [m].
        side: -1, 0 or 1 along the closing axis: a box moves outwards by side * opening / 2, shape (n,).
        axis: the closing direction, shape (3,).
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    side: NDArray[np.float64]
    axis: NDArray[np.float64]

    def opened(self, opening: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper corners for each opening [m], shapes (k, n, 3)."""
        shift = (0.5 * opening[:, None] * self.side)[:, :, None] * self.axis
        return self.lower + shift, self.upper + shift


@cache
def hand_boxes(robot: RobotModel) -> HandBoxes:
    """Cut the hand's and fingers' hulls into slices along the approach and box each slice."""
    axis = np.array(robot.spec.gripper.axis)
    lower, upper, side = [], [], []
    for points in hand_points(robot, opening=0.0):
        along = points @ axis
        which = 0.0 if along.min() < -1e-3 and along.max() > 1e-3 else float(np.sign(along.mean()))
        for low, high in _slices(points):
            lower.append(low)
            upper.append(high)
            side.append(which)
    return HandBoxes(np.array(lower), np.array(upper), np.array(side), axis)


def _slices(points: NDArray[np.float64]) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Boxes round slices of a convex point cloud between cuts along z."""
    cuts = np.linspace(points[:, 2].min(), points[:, 2].max(), SLICES + 1)
    start, end = (grid.ravel() for grid in np.meshgrid(np.arange(len(points)), np.arange(len(points))))
    boxes = []
    for low, high in itertools.pairwise(cuts):
        inside = [points[(points[:, 2] >= low - 1e-9) & (points[:, 2] <= high + 1e-9)]]
        # Segments between any two points of a convex body lie in it: where they cross a cut bounds the slice.
        for cut in (low, high):
            a, b = points[start], points[end]
            crossing = (a[:, 2] < cut) & (b[:, 2] > cut)
            t = (cut - a[crossing, 2]) / (b[crossing, 2] - a[crossing, 2])
            inside.append(a[crossing] + t[:, None] * (b[crossing] - a[crossing]))
        slab = np.concatenate(inside)
        boxes.append((slab.min(axis=0), slab.max(axis=0)))
    return boxes


def points_hit(
    boxes: HandBoxes, openings: NDArray[np.float64], T_tool_points: NDArray[np.float64], margin: float = 0.0
) -> NDArray[np.bool_]:
    """Whether any point lies inside any box.

    Args:
        boxes: the hand.
        openings: one for each grasp, shape (k,) [m].
        T_tool_points: points in each grasp's tool frame, shape (k, m, 3) [m].
        margin: boxes grow by this on every side [m].

    Returns:
        One answer for each grasp, shape (k,).
    """
    lower, upper = boxes.opened(openings)
    hit = np.zeros(len(openings), bool)
    for box in range(lower.shape[1]):
        # One axis after the other over whole arrays: many times faster than testing points of three coordinates.
        inside = np.ones(T_tool_points.shape[:2], bool)
        for axis in range(3):
            along = T_tool_points[:, :, axis]
            inside &= along > lower[:, box, axis, None] - margin
            inside &= along < upper[:, box, axis, None] + margin
        hit |= inside.any(axis=1)
    return hit


def lowest_point(
    boxes: HandBoxes, openings: NDArray[np.float64], T_world_tool: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Height of the lowest corner of the hand above the world's z = 0 for each grasp, shape (k,) [m]."""
    lowest: NDArray[np.float64] = _least(boxes, openings, T_world_tool, np.array([0.0, 0.0, 1.0])).min(axis=1)
    return lowest


def clear_of_slab(
    boxes: HandBoxes,
    openings: NDArray[np.float64],
    T_world_tool: NDArray[np.float64],
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
    gap: float,
) -> NDArray[np.bool_]:
    """Whether each hand stays clear of all that is under a level rectangle at z = 0, by `gap` [m]; shape (k,).

    The rectangle's corners are `lower` and `upper`, shape (2,) [m]; the rest is as for `lowest_point`.
    """
    clear = _least(boxes, openings, T_world_tool, np.array([0.0, 0.0, 1.0])) > gap
    for axis in range(2):
        outward = np.eye(3)[axis]
        clear |= _least(boxes, openings, T_world_tool, outward) > upper[axis] + gap
        clear |= _least(boxes, openings, T_world_tool, -outward) > gap - lower[axis]
    beside: NDArray[np.bool_] = np.all(clear, axis=1)
    return beside


def _least(
    boxes: HandBoxes,
    openings: NDArray[np.float64],
    T_world_tool: NDArray[np.float64],
    direction: NDArray[np.float64],
) -> NDArray[np.float64]:
    """How far along a direction (3,) of the world each box of each hand begins, shape (k, n) [m]."""
    along = direction @ T_world_tool[:, :3, :3]
    least = np.maximum(along, 0.0) @ boxes.lower.T + np.minimum(along, 0.0) @ boxes.upper.T
    least += (0.5 * openings * (along @ boxes.axis))[:, None] * boxes.side
    found: NDArray[np.float64] = least + (T_world_tool[:, :3, 3] @ direction)[:, None]
    return found


def boxes_in_world(
    boxes: HandBoxes, openings: NDArray[np.float64], T_world_tool: NDArray[np.float64], margin: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of the world's boxes around the boxes of each hand, grown by `margin` [m]; shapes (k, n, 3) [m]."""
    lower, upper = boxes.opened(openings)
    R = T_world_tool[:, :3, :3]
    middle = np.einsum("kij,knj->kni", R, (lower + upper) / 2) + T_world_tool[:, None, :3, 3]
    reach = np.einsum("kij,knj->kni", np.abs(R), (upper - lower) / 2) + margin
    return middle - reach, middle + reach
