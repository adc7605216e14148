"""Where one straight push does not bring an object to an edge of the table, two do: from anywhere to any end in reach.

Nothing turns on its way, so an end at an edge is the start plus two shifts along two of the directions in which the
object can be pushed; those determine how long each shift is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.slide_path import (
    LEAST_OVERHANG,
    LONGEST,
    OVERHANGS,
    STEEPEST,
    Direction,
    Way,
    center_from_above,
    edges,
    shifted,
    stands,
    steady,
)
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SPACING = 0.06  # of ends along an edge [m]
SHORTEST = 0.02  # push [m]
SQUARE = 0.2  # sine of the angle between two pushes, at least: else one would nearly do


@dataclass(frozen=True, eq=False)
class End:
    """Where an object can hang over an edge.

    Attributes:
        placement: there.
        shift: from where it stands, (2,) [m].
        outward: unit vector over the edge, (2,).
        hanging: how far it hangs over, as a share of how far it can.
    """

    placement: Placement
    shift: Array
    outward: Array
    hanging: float


def ends(workspace: Workspace, obj: str, placement: Placement) -> list[End]:
    """Ends within the arm's reach, those over which most of the object hangs first.

    Among equal ones those come first that are neither near to the arm nor far from it.
    """
    spec = workspace.world.robot.spec
    base = np.array(spec.T_world_base.xyz[:2])
    distance = {
        end: float(np.linalg.norm(end.placement.pose.xyz[:2] - base)) for end in _ends(workspace, obj, placement)
    }
    near, far = spec.reach
    found = [end for end in distance if near < distance[end] < far and stands(workspace, obj, end.placement)]
    return sorted(found, key=lambda end: (-end.hanging, abs(distance[end] - (near + far) / 2)))


def _ends(workspace: Workspace, obj: str, placement: Placement) -> Iterator[End]:
    spec = workspace.world.robot.spec
    from_base = np.subtract(placement.pose.xyz, spec.T_world_base.xyz)[:2]
    center = center_from_above(workspace, obj, placement)
    lattice = SPACING * np.arange(-int(spec.reach[1] / SPACING), int(spec.reach[1] / SPACING) + 1)
    for edge in edges(workspace, obj, placement):
        along = np.array([-edge.outward[1], edge.outward[0]])
        for hanging in (share for share in OVERHANGS if share * edge.farthest > LEAST_OVERHANG):
            for beside in lattice:
                shift = (edge.room + hanging * edge.farthest) * edge.outward + (beside - from_base @ along) * along
                if steady(workspace, center + shift):
                    yield End(shifted(placement, shift), shift, edge.outward, hanging)


def detours(
    workspace: Workspace, obj: str, placement: Placement, end: End, among: Sequence[Direction]
) -> Iterator[tuple[Way, Way]]:
    """Yield pairs of ways that bring an object to one of its ends by two of its directions, the shortest in sum first.

    Between the two the whole object is on the table.
    """
    ahead = np.array([direction.ahead for direction in among]).reshape(-1, 2)
    across = _cross(ahead[:, None], ahead[None])
    # shift = lengths[0] * first + lengths[1] * second, by Cramer's rule
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = np.stack([_cross(end.shift, ahead)[None] / across, _cross(ahead, end.shift)[:, None] / across])
    able = (np.abs(across) > SQUARE) & ((lengths > SHORTEST) & (lengths < LONGEST)).all(axis=0)
    firsts, seconds = np.nonzero(able & (ahead @ end.outward > STEEPEST)[None])
    for index in np.argsort(lengths[:, firsts, seconds].sum(axis=0), kind="stable"):
        first, second = among[firsts[index]], among[seconds[index]]
        begin, last = (float(length) for length in lengths[:, firsts[index], seconds[index]])
        between = begin * first.ahead
        if _whole(workspace, obj, placement, between):
            yield first.way(placement, np.zeros(2), begin, 0.0), second.way(placement, between, last, end.hanging)


def _cross(one: Array, other: Array) -> Array:
    """The vertical component of the product of level vectors, shapes (..., 2)."""
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])


def _whole(workspace: Workspace, obj: str, placement: Placement, shift: Array) -> bool:
    """Whether the whole object is on the table after a shift, (2,) [m]."""
    lower, upper = (bound[:2] + shift for bound in workspace.bounds(obj, placement.pose))
    middle, half = np.array(workspace.task.table.center), np.array(workspace.task.table.size) / 2
    return bool((lower > middle - half).all() and (upper < middle + half).all())
