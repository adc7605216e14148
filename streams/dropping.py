"""Dropping: an object is let go above its placement and falls straight down, out of the opening fingers.

That is for what shall lie in something, where walls leave no room for the hand further down: they keep what falls.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.clearance import beneath, standing_around
from tamp.streams.collisions import CONTACT_DEPTH
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

HEIGHTS = (0.01, 0.02, 0.04, 0.06, 0.08, 0.10, 0.12, 0.14, 0.16)  # that an object may fall from [m]
PASSED = 0.01  # between two poses of a fall [m]
SUNK = 0.02  # an object lies in what reaches this much higher than its own lowest point [m]

Fall = tuple[Pose, ...]


def drops(workspace: Workspace, obj: str, placement: Placement) -> tuple[Fall, ...]:
    """Ways down to a placement, each the poses that the object passes, the placement's last; the shortest first.

    All are clear of what carries the object; none where it does not lie in anything.
    """
    around = standing_around(workspace, obj, placement)
    carriers = {name: around[name] for name in beneath(placement, around)}
    key = ("drops", obj, placement, *carriers.items())
    if key not in workspace.memory:
        workspace.memory[key] = _drops(workspace, obj, placement, carriers)
    falls: tuple[Fall, ...] = workspace.memory[key]
    return falls


def _drops(workspace: Workspace, obj: str, placement: Placement, carriers: Mapping[str, Placement]) -> tuple[Fall, ...]:
    if not lies_in(workspace, obj, placement, carriers):
        return ()
    under = {name: place.pose.matrix for name, place in carriers.items()}
    path = [placement.pose, *(_raised(placement.pose, h) for h in np.arange(PASSED, HEIGHTS[-1] + 1e-9, PASSED))]
    free = 0
    while free < len(path) and not _within(workspace, obj, path[free], under):
        free += 1
    counts = (round(height / PASSED) + 1 for height in HEIGHTS)
    return tuple(tuple(reversed(path[:count])) for count in counts if count <= free)


def lies_in(workspace: Workspace, obj: str, placement: Placement, carriers: Mapping[str, Placement]) -> bool:
    """Whether an object lies in one of those that carry it, directly or through others."""
    lower, upper = workspace.bounds(obj, placement.pose)
    middle = (lower + upper)[:2] / 2
    for name, place in carriers.items():
        low, high = workspace.bounds(name, place.pose)
        if (low[:2] < middle).all() and (middle < high[:2]).all() and high[2] > lower[2] + SUNK:
            return True
    return False


def _raised(pose: Pose, height: float) -> Pose:
    """A pose, moved up by a height [m]."""
    x, y, z = pose.xyz
    return Pose((x, y, z + float(height)), pose.quat)


def _within(workspace: Workspace, obj: str, pose: Pose, others: Mapping[str, NDArray[np.float64]]) -> bool:
    """Whether an object at a pose is inside any of some others."""
    return any(
        workspace.world.overlap(obj, pose.matrix, name, T, tolerance=CONTACT_DEPTH) for name, T in others.items()
    )
