"""The hand as a few boxes in the tool frame: coarse, but thousands of grasps are sieved with it at once."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.world.robot.hand import hand_points

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.robot.model import RobotModel

SLICES = 2  # boxes along the approach direction that a link is cut into
FINE = 16  # the same of fingers that push


@dataclass(frozen=True, eq=False)
class HandBoxes:
    """Boxes in the tool frame: straight between tabulated openings.

    Attributes:
        grid: the openings, shape (g,) [m].
        lower, upper: corners at each, shape (g, n, 3) [m].
        lower_rate, upper_rate: how they move for a metre of opening from each on, shape (g - 1, n, 3).
        side: -1, 0 or 1: on which side of the closing axis a box is with the pads touching each other, shape (n,).
    """

    grid: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    lower_rate: NDArray[np.float64]
    upper_rate: NDArray[np.float64]
    side: NDArray[np.float64]

    def spans(self, openings: NDArray[np.float64]) -> NDArray[np.int64]:
        """Between which two tabulated openings each opening is: the index of the lower one, shape (k,)."""
        found: NDArray[np.int64] = np.clip(
            np.searchsorted(self.grid, openings, side="right") - 1, 0, len(self.lower_rate) - 1
        )
        return found

    def opened(self, openings: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper corners for each opening [m], shapes (k, n, 3)."""
        i = self.spans(openings)
        beyond = (openings - self.grid[i])[:, None, None]
        return self.lower[i] + beyond * self.lower_rate[i], self.upper[i] + beyond * self.upper_rate[i]

    def tip(self, opening: float) -> float:
        """How far the fingers reach along the tool's z at an opening [m]."""
        return float(self.opened(np.array([opening]))[1][0, self.side != 0.0, 2].max())

    def palm(self, opening: float) -> float:
        """How far what is not a finger reaches along the tool's z at an opening [m]."""
        return float(self.opened(np.array([opening]))[1][0, self.side == 0.0, 2].max())


STRETCHES = 16
"""Into so many the stroke of fingers that swing is parted; the boxes are wrong by a tenth of a millimetre at most."""


@cache
def hand_boxes(robot: RobotModel) -> HandBoxes:
    """Cut the hand's and fingers' hulls into slices along the approach and box each slice."""
    axis, every = np.array(robot.spec.gripper.axis), robot.linkage.grid
    grid = every if len(every) == 2 else np.linspace(0.0, robot.spec.gripper.stroke, STRETCHES + 1)
    side = []
    for points in hand_points(robot, opening=0.0):
        along = points @ axis
        which = 0.0 if along.min() < -1e-3 and along.max() > 1e-3 else float(np.sign(along.mean()))
        side += [which] * SLICES
    if len(every) == 2:  # fingers that slide
        boxes = _sliced(robot, opening=0.0)
        corners = np.array(boxes)[None].repeat(2, axis=0)
        rate = 0.5 * np.array(side)[None, :, None] * axis
        corners[1] += (robot.spec.gripper.stroke * rate[0])[:, None]
        return HandBoxes(grid, corners[:, :, 0], corners[:, :, 1], rate, rate, np.array(side))
    corners = np.array([_sliced(robot, float(opening)) for opening in grid])
    rates = np.diff(corners, axis=0) / np.diff(grid)[:, None, None, None]
    return HandBoxes(grid, corners[:, :, 0], corners[:, :, 1], rates[:, :, 0], rates[:, :, 1], np.array(side))


def finger_reach(
    robot: RobotModel, opening: float, ahead: NDArray[np.float64], above: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How far upright fingers reach ahead at each height, as they get wider or narrower towards their tips.

    Args:
        robot: whose hand it is.
        opening: distance between the pads [m].
        ahead: unit vector across the tool's z, in the tool frame, shape (3,).
        above: up to how far above the tips [m].

    Returns:
        Slices of the fingers: their bounds above the tips, shape (n, 2), and how far ahead each reaches, (n,) [m].
    """
    turned = np.stack([ahead, np.cross((0.0, 0.0, 1.0), ahead), (0.0, 0.0, 1.0)], axis=1)
    boxes = hand_boxes(robot)
    links = zip(_links(robot, opening), boxes.side[::SLICES], strict=True)
    found = [box for (points, ends), side in links if side != 0.0 for box in _slices(points @ turned, ends, FINE)]
    tip = boxes.tip(opening)
    bounds = np.array([(tip - upper[2], tip - lower[2]) for lower, upper in found])
    low = bounds[:, 0] < above
    return bounds[low], np.array([upper[0] for _, upper in found])[low]


def _links(robot: RobotModel, opening: float) -> list[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Vertices (n, 3) of each link's hull in the tool frame, and between which of them its edges run, (m, 2)."""
    faces = (robot.bodies[index].hull.faces for index in robot.hand)
    edges = (np.vstack([each[:, [0, 1]], each[:, [1, 2]], each[:, [2, 0]]]) for each in faces)
    return list(zip(hand_points(robot, opening), edges, strict=True))


def _sliced(robot: RobotModel, opening: float) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Boxes round the slices of all links of the hand at an opening [m]."""
    links = _links(robot, opening)
    return [box for points, ends in links for box in _slices(points, ends, SLICES)]


def _slices(
    points: NDArray[np.float64], edges: NDArray[np.int64], count: int
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Boxes round slices of a convex body between cuts along z.

    Args:
        points: its vertices, shape (n, 3) [m].
        edges: between which of them its edges run, each both ways, shape (m, 2).
        count: of slices.
    """
    cuts = np.linspace(points[:, 2].min(), points[:, 2].max(), count + 1)
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    boxes = []
    for low, high in itertools.pairwise(cuts):
        inside = [points[(points[:, 2] >= low - 1e-9) & (points[:, 2] <= high + 1e-9)]]
        for cut in (low, high):  # where edges cross a cut are the corners of what lies in it
            crossing = (a[:, 2] < cut) & (b[:, 2] > cut)
            t = (cut - a[crossing, 2]) / (b[crossing, 2] - a[crossing, 2])
            inside.append(a[crossing] + t[:, None] * (b[crossing] - a[crossing]))
        slab = np.concatenate(inside)
        boxes.append((slab.min(axis=0), slab.max(axis=0)))
    return boxes


def points_hit(
    boxes: HandBoxes,
    openings: NDArray[np.float64],
    T_tool: NDArray[np.float64],
    points: NDArray[np.float64],
    margin: float = 0.0,
) -> NDArray[np.bool_]:
    """Whether any point lies inside any box.

    Args:
        boxes: the hand.
        openings: one for each grasp, shape (k,) [m].
        T_tool: each grasp's tool frame in that of the points, shape (k, 4, 4).
        points: shape (m, 3) [m].
        margin: boxes grow by this on every side [m].

    Returns:
        One answer for each grasp, shape (k,).
    """
    lower, upper = boxes.opened(openings)
    return _points_hit(lower - margin, upper + margin, np.array(T_tool, order="C"), np.array(points, order="C"))


@compiled
def _points_hit(
    lower: NDArray[np.float64], upper: NDArray[np.float64], T: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.bool_]:
    hit, local, first, last = np.zeros(len(T), np.bool_), np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(T)):
        for i in range(3):
            first[i], last[i] = lower[k, :, i].min(), upper[k, :, i].max()
        for m in range(len(points)):
            x, y, z = points[m, 0] - T[k, 0, 3], points[m, 1] - T[k, 1, 3], points[m, 2] - T[k, 2, 3]
            around = True
            for i in range(3):
                local[i] = T[k, 0, i] * x + T[k, 1, i] * y + T[k, 2, i] * z
                around = around and first[i] < local[i] < last[i]
            if not around:  # most points are beside all of the boxes
                continue
            for box in range(lower.shape[1]):
                low, high = lower[k, box], upper[k, box]
                if low[0] < local[0] < high[0] and low[1] < local[1] < high[1] and low[2] < local[2] < high[2]:
                    hit[k] = True
                    break
            if hit[k]:
                break
    return hit


def clear_of_slab(
    boxes: HandBoxes,
    openings: NDArray[np.float64],
    T_world: NDArray[np.float64],
    T_tool: NDArray[np.float64],
    slab: tuple[NDArray[np.float64], NDArray[np.float64]],
    gap: float,
) -> NDArray[np.bool_]:
    """Whether each hand keeps a gap to all that is under a level rectangle at z = 0: above it, or beside it.

    Args:
        boxes: the hand.
        openings: one for each grasp, shape (k,) [m].
        T_world: the frame that the tools are given in, shape (4, 4).
        T_tool: each grasp's tool frame in that, shape (k, 4, 4).
        slab: lower and upper corner of the rectangle, shape (2,) each [m]; only a hand whose tool is beside it may be
            lower.
        gap: the least distance [m].

    Returns:
        One answer for each grasp, shape (k,).
    """
    i = boxes.spans(openings)
    corners = np.array([boxes.lower[:-1], boxes.upper[:-1]])
    rates = np.array([boxes.lower_rate, boxes.upper_rate])
    frames = np.array(T_world, order="C"), np.array(T_tool, order="C")
    return _clear_of_slab(corners, rates, i, openings - boxes.grid[i], *frames, np.array(slab), gap)


@compiled
def _clear_of_slab(
    corners: NDArray[np.float64],
    rates: NDArray[np.float64],
    spans: NDArray[np.int64],
    beyond: NDArray[np.float64],
    T_world: NDArray[np.float64],
    T_tool: NDArray[np.float64],
    slab: NDArray[np.float64],
    gap: float,
) -> NDArray[np.bool_]:
    clear, R, t, low, high = np.ones(len(T_tool), np.bool_), np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(T_tool)):
        for i in range(3):
            t[i] = T_world[i, 3]
            for m in range(3):
                t[i] += T_world[i, m] * T_tool[k, m, 3]
                R[i, m] = 0.0
                for n in range(3):
                    R[i, m] += T_world[i, n] * T_tool[k, n, m]
        beside = t[0] < slab[0, 0] or t[0] > slab[1, 0] or t[1] < slab[0, 1] or t[1] > slab[1, 1]
        for box in range(corners.shape[2]):
            for m in range(3):
                low[m] = corners[0, spans[k], box, m] + beyond[k] * rates[0, spans[k], box, m]
                high[m] = corners[1, spans[k], box, m] + beyond[k] * rates[1, spans[k], box, m]
            apart = t[2] + _least(R[2], low, high, 1.0) > gap
            for i in range(2):
                if apart or not beside:
                    break
                apart = t[i] + _least(R[i], low, high, 1.0) > slab[1, i] + gap
                apart = apart or -t[i] + _least(R[i], low, high, -1.0) > gap - slab[0, i]
            if not apart:
                clear[k] = False
                break
    return clear


@compiled
def _least(row: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64], sign: float) -> float:
    """How far a box begins along an axis of the world, or against it, of which `row` holds the components."""
    least = 0.0
    for m in range(3):
        along = sign * row[m]
        least += along * (low[m] if along > 0.0 else high[m])
    return least


def near_boxes(
    boxes: HandBoxes,
    openings: NDArray[np.float64],
    T_world_tool: NDArray[np.float64],
    margin: float,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Whether the box in the world around any box of each hand, grown by `margin` [m], meets some boxes there.

    Args:
        boxes: the hand.
        openings: one for each hand, shape (k,) [m].
        T_world_tool: where it is, shape (k, 4, 4).
        margin: how much the hand's boxes grow on every side [m].
        low: lower corners of the boxes in the world, shape (m, 3) [m].
        high: their upper corners, shape (m, 3) [m].

    Returns:
        One answer for each hand and each of the others, shape (k, m).
    """
    return _near_boxes(
        *boxes.opened(openings), np.array(T_world_tool, order="C"), margin, np.array(low), np.array(high)
    )


@compiled
def _near_boxes(
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
    T: NDArray[np.float64],
    margin: float,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> NDArray[np.bool_]:
    near, middle, reach = np.zeros((len(T), len(low)), np.bool_), np.empty(3), np.empty(3)
    for k in range(len(T)):
        for box in range(lower.shape[1]):
            for i in range(3):
                middle[i], reach[i] = T[k, i, 3], margin
                for j in range(3):
                    middle[i] += T[k, i, j] * (lower[k, box, j] + upper[k, box, j]) / 2
                    reach[i] += abs(T[k, i, j]) * (upper[k, box, j] - lower[k, box, j]) / 2
            for m in range(len(low)):
                meets = True
                for i in range(3):
                    meets = meets and low[m, i] - reach[i] < middle[i] < high[m, i] + reach[i]
                near[k, m] = near[k, m] or meets
    return near
