"""Where an object comes to rest that is lowered or dropped among others that stay where they are."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tamp.execution.settling import settle
from tamp.pipeline.situation import placements, raised
from tamp.streams.placements import RELEASE_HEIGHT
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose

LOWERINGS = 48  # steps on the way down
SETTLING_S = 3.0  # an object that moves longer than this has no place there
PUSHED = 0.005  # what the others move at most when an object settles among them [m]
AROUND = 0.05  # an object may meet others this far beside it as it comes to rest [m]


def lowered(
    workspace: Workspace, name: str, pose: Pose, least: float, others: Mapping[str, Placement]
) -> Placement | None:
    """Lower an object straight down from a pose until it touches something; None where that takes too many steps.

    Args:
        workspace: the shapes.
        name: the object.
        pose: where it begins (world frame), clear of all others.
        least: the height of its origin when it is just above the table [m].
        others: what stands in its way.
    """
    T = pose.matrix
    beside = {other: place.pose.matrix for other, place in others.items()}
    for _ in range(LOWERINGS):
        gaps = {other: workspace.world.separation(name, T, other, T_other) for other, T_other in beside.items()}
        down = min([gap - RELEASE_HEIGHT for gap in gaps.values()], default=math.inf)
        if down < RELEASE_HEIGHT:
            touched = [other for other, gap in gaps.items() if gap < 2 * RELEASE_HEIGHT]
            return Placement(Pose.from_matrix(T), tuple(sorted(touched)))
        if T[2, 3] == least:
            return Placement(Pose.from_matrix(T), (TABLE,))
        # Lowering by the distance cannot make them touch, whatever their shapes (conservative advancement).
        T = T + np.outer([0, 0, 1, 0], [0, 0, 0, max(least - T[2, 3], -down)])
    return None


def settled(workspace: Workspace, name: str, place: Placement) -> Placement | None:
    """Where an object comes to rest that is let go at a place; None where that pushes others or it falls off the table.

    Args:
        workspace: what else stands where.
        name: the object.
        place: where it is let go.
    """
    poses = {other: workspace.start[other].pose for other in _company(workspace, name, place)}
    after = settle(workspace.task, {**poses, name: place.pose}, limit_s=SETTLING_S)
    pushed = any(moved > PUSHED for other, moved in after.moved.items() if other != name)
    if pushed or not after.resting or after.poses[name].xyz[2] < -workspace.task.table.thickness:
        return None
    return raised(placements(after.poses, after.supports)[name])


def _company(workspace: Workspace, name: str, place: Placement) -> list[str]:
    """What an object may meet as it comes to rest, and whatever that rests on or carries; all else keeps still."""
    low, high = workspace.bounds(name, place.pose)
    found, touched = set[str](), set[str]()
    for other, standing in workspace.start.items():
        lower, upper = workspace.bounds(other, standing.pose)
        if other != name and (lower < high + AROUND)[:2].all() and (upper > low - AROUND)[:2].all():
            touched.add(other)
    pairs = [{other, *standing.on} - {TABLE, name} for other, standing in workspace.start.items() if other != name]
    while touched > found:
        found = set(touched)
        touched = found.union(*(pair for pair in pairs if pair & found))
    return sorted(found)
