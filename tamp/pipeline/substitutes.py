"""Second-best goals: where on the table an object that cannot reach its goal pose comes nearest to it.

The score counts how near an object ends, so even one whose support is missing is worth bringing near.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tamp.scoring.ede import ede, mean_edge
from tamp.streams.footing import stands
from tamp.streams.placements import RELEASE_HEIGHT
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.geometry import stable_poses

if TYPE_CHECKING:
    from numpy.typing import NDArray

GAIN = 0.03  # a placement must bring the object this much nearer to its goal (EDE) [m]
LIKELY = 0.02  # stable poses less probable than this are left out
RINGS, SPOKES, SPACING = 8, 12, 0.025  # positions tried round the goal; rings lie this far apart [m]
ROOMS = (0.004, 0.04)  # kept from everything that stands there: hardly any, or enough for the hand [m]


def substitutes(workspace: Workspace, name: str, count: int) -> list[Placement]:
    """Free stable placements on the table, the nearest to an object's goal first; half with room for the hand.

    Args:
        workspace: what stands where, and what the goals mean.
        name: an object whose goal is a pose.
        count: how many at most, 2 or more.
    """
    edge = mean_edge(workspace.task.object(name).shape)
    goal, start = workspace.goals[name].pose, workspace.start[name].pose
    enough = ede(edge, start, goal) - GAIN
    found: dict[Placement, float] = {}
    for room in ROOMS:
        best = (
            next((p for p in _around(workspace, name, R) if _free(workspace, name, p.pose, room)), None)
            for R in _rotations(workspace, name)
        )
        near = {place: ede(edge, place.pose, goal) for place in best if place is not None}
        found |= dict(sorted(near.items(), key=lambda item: item[1])[: count // len(ROOMS)])
    return [place for place, error in sorted(found.items(), key=lambda item: item[1]) if error < enough]


def _rotations(workspace: Workspace, name: str) -> Iterator[NDArray[np.float64]]:
    """Each stable orientation (3, 3), turned about the vertical as near to the goal's as it comes."""
    wanted, here = workspace.goals[name].pose.matrix[:3, :3], workspace.start[name]
    geometry = workspace.world.geometries[name]
    faces = [pose.R for pose in stable_poses(geometry) if pose.probability > LIKELY and stands(geometry, pose.R)]
    # A ball has many faces, none of them likely, but it rests as it lies now.
    for R in [here.pose.matrix[:3, :3], *faces] if here.on == (TABLE,) else faces:
        M = R @ wanted.T
        # The angle that maximises the trace of Rz(angle) M.
        angle = np.arctan2(M[0, 1] - M[1, 0], M[0, 0] + M[1, 1])
        c, s = np.cos(angle), np.sin(angle)
        yield np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ R


def _around(workspace: Workspace, name: str, R: NDArray[np.float64]) -> Iterator[Placement]:
    """Placements on the table in one orientation, the nearest to the goal's position first."""
    points = np.concatenate([part.vertices for part in workspace.world.geometries[name].parts]) @ R.T
    low, high = points.min(axis=0), points.max(axis=0)
    table = workspace.task.table
    middle, half = np.array(table.center), np.array(table.size) / 2
    T = np.eye(4)
    T[:3, :3] = R
    for ring in range(RINGS):
        for spoke in range(SPOKES if ring else 1):
            angle = 2 * np.pi * spoke / SPOKES
            offset = SPACING * ring * np.array([np.cos(angle), np.sin(angle)])
            T[:2, 3] = np.array(workspace.goals[name].pose.xyz[:2]) + offset
            T[2, 3] = RELEASE_HEIGHT - low[2]
            if (T[:2, 3] + low[:2] > middle - half).all() and (T[:2, 3] + high[:2] < middle + half).all():
                yield Placement(Pose.from_matrix(T), (TABLE,))


def _free(workspace: Workspace, name: str, pose: Pose, room: float) -> bool:
    """Whether nothing that stands there is nearer than `room` [m]."""
    return not any(
        workspace.world.overlap(name, pose.matrix, other, place.pose.matrix, tolerance=-room)
        for other, place in workspace.start.items()
        if other != name
    )
