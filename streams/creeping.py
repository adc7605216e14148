"""How much friction it takes to keep an object from creeping out between the pads.

Pads that meet an object at places that do not face each other, a curved rim at a corner of one and the middle of the
other, turn and shift it at once, and let it go while neither alone would set energy free. The slightest motion already
tells: it is possible where the pads come closer by more than friction takes along the way (a grasp resists what
force closure asks of its contacts: Nguyen, "Constructing force-closure grasps", IJRR 1988).
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.squeezed import Side, Squeezed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP = 0.0015  # how far the object is moved [m]
LEVER = 0.015  # turning it by the step over this counts as much [m]
TOUCHING = 0.0006  # what lies so near to a pad is taken to touch it [m]
PATCH = 0.002  # how far from its middle a touch resists turning about the closing axis [m]
WAYS = 500  # that are looked at first
CLOSER = (0.4, 0.2, 0.1)  # then as far from the best one so far
NEIGHBOURS = 100  # ways each time


def creeping(squeezed: Squeezed) -> float:
    """The friction coefficient of pads on the object below which it would creep out; 0 or less where none is needed.

    Args:
        squeezed: the object in the grasp.
    """
    low, high = squeezed.sides()
    if not len(low.heights):
        return 0.0
    bottom, top = float(low.heights.min()), float(high.heights.max())
    middles = [side.points[touching].mean(axis=0) for side, touching in (
        (low, low.heights < bottom + TOUCHING), (high, high.heights > top - TOUCHING))]  # fmt: skip
    slopes = _slopes(low), _slopes(high)

    def needed(ways: Array) -> Array:
        """For each of the motions (n, 5): shifts along side and approach, turns about side, closing and approach."""
        reached = high.heights + ways @ slopes[1].T, low.heights + ways @ slopes[0].T
        closer = top - bottom - (reached[0].max(axis=1) - reached[1].min(axis=1))
        rubbed = 2 * PATCH * np.abs(ways[:, 3]) / LEVER
        for middle in middles:
            rubbed += np.hypot(*(ways @ _rubbing(middle)).T)
        ratios: Array = closer / rubbed
        return ratios

    found = STEP * _ways(WAYS, 0)
    ratios = needed(found)
    most, best = float(ratios.max()), found[ratios.argmax()]
    for seed, share in enumerate(CLOSER, 1):
        found = best + STEP * share * _ways(NEIGHBOURS, seed)
        ratios = needed(found)
        if ratios.max() > most:
            most, best = float(ratios.max()), found[ratios.argmax()]
    return most


def _slopes(side: Side) -> Array:
    """How far its surface comes along the closing axis with each of the five motions, shape (rays, 5)."""
    n = side.normals
    moments = np.cross(side.points, n) / LEVER
    slopes: Array = np.column_stack([n[:, 0], n[:, 2], moments]) / n[:, 1:2]
    return slopes


def _rubbing(point: Array) -> Array:
    """How a point moves along the pads, in the side and the approach direction, with each motion; shape (5, 2)."""
    x, y, z = point / LEVER
    return np.array([[1.0, 0.0], [0.0, 1.0], [0.0, y], [z, -x], [-y, 0.0]])


@lru_cache(maxsize=8)
def _ways(count: int, seed: int) -> Array:
    """Motions in all directions, shape (count, 5), of length one; the same for every seed of a task."""
    ways: Array = np.random.default_rng(seed).normal(size=(count, 5))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    ways.setflags(write=False)
    return ways
