"""Dropping: an object is let go above its placement and falls straight down, out of the opening fingers.

That is for what shall lie in something, where walls leave no room for the hand further down: they keep what falls.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import in_equilibrium
from tamp.streams.affordances.neighbours import carriers, lies_in
from tamp.streams.affordances.stable_poses import inside_by, outline
from tamp.streams.affordances.stack_balance import contacts
from tamp.streams.affordances.support import inside_support
from tamp.streams.affordances.tilts import layable, tilts
from tamp.streams.collisions import CONTACT_DEPTH
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

HEIGHTS = (0.01, 0.02, 0.04, 0.06, 0.08, 0.10, 0.12, 0.14, 0.16)  # that an object may fall from [m]
PASSED = 0.01  # between two poses of a fall [m]
LEFT = 0.002  # share of a fall that lifts what has come down, where it tips or rolls
ROCKING = 0.01  # and the most of that as a share of the height of its centre of mass
SURE = 1.25  # so many times as far inside what carries it the centre of mass is as it needs to be ...
GIVEN = 0.002  # ... and a little farther: where it is carried is known as well as its surface is felt [m]
RESTS = 0.002  # surface so near to what carries rests on it [m]

Fall = tuple[Pose, ...]


def drops(workspace: Workspace, obj: str, placement: Placement) -> tuple[Fall, ...]:
    """Ways down to a placement, each the poses that the object passes, the placement's last; the shortest first.

    All are clear of what carries the object; none where it does not lie in anything, and none so high that it would
    roll or tip on where it lands.
    """
    below = carriers(workspace, obj, placement)
    key = ("drops", obj, placement, *below.items())
    return workspace.cache.value(key, lambda: _drops(workspace, obj, placement, below))


def _drops(workspace: Workspace, obj: str, placement: Placement, below: Mapping[str, Placement]) -> tuple[Fall, ...]:
    if not lies_in(workspace, obj, placement, below):
        return ()
    under = {name: place.pose.matrix for name, place in below.items()}
    path = [placement.pose, *(_raised(placement.pose, h) for h in np.arange(PASSED, HEIGHTS[-1] + 1e-9, PASSED))]
    free = 0
    while free < len(path) and not _within(workspace, obj, path[free], under):
        free += 1
    around = {name: place for name, place in below.items() if name in placement.on}
    inside = inside_support(workspace, obj, placement, around, RESTS)

    def firm(height: float) -> bool:
        rocks = _rocks(workspace, obj, placement, height)
        held = rocks < inside or in_equilibrium(workspace, {obj: placement}, below, rocks)  # walls hold what leans
        return held and _withstood(workspace, obj, placement, below, height, inside)

    counts = {height: round(height / PASSED) + 1 for height in HEIGHTS}
    heights = [height for height in HEIGHTS if counts[height] <= free]
    # Who stands a fall from higher up stands a lower one too.
    stood = (
        bisect_left(heights, True, key=lambda height: not firm(height)) if heights and not firm(heights[-1]) else None
    )
    return tuple(tuple(reversed(path[: counts[height]])) for height in heights[:stood])


def _rocks(workspace: Workspace, obj: str, placement: Placement, height: float) -> float:
    """How far aside the centre of mass of what falls from a height may go by what is left of the fall [m].

    It rises by that as it tips over an edge, which it does not where the edge is farther from it.
    """
    geometry, R = workspace.world.geometries[obj], placement.pose.matrix[:3, :3]
    center = float(R[2] @ geometry.center_of_mass - (geometry.hull.vertices @ R[2]).min())
    rises = min(LEFT * height, ROCKING * center)
    return SURE * math.sqrt((center + rises) ** 2 - center**2) + GIVEN


def _withstood(
    workspace: Workspace,
    obj: str,
    placement: Placement,
    below: Mapping[str, Placement],
    height: float,
    inside: float,
) -> bool:
    """Whether what carries an object that falls from a height [m] onto it, each alone, does not tip over.

    What is left of the fall may lift their common centre of mass over the edge of what carries them. It does not where
    that is far enough inside what carries each straight up, which the object itself is by `inside` [m]; else walls and
    friction may hold them.
    """
    mass, center, pile, name = 0.0, np.zeros(3), {obj: placement}, obj
    energy = workspace.task.object(obj).mass * height
    while True:
        T, more = pile[name].pose.matrix, workspace.task.object(name).mass
        middle = T[:3, :3] @ workspace.world.geometries[name].center_of_mass + T[:3, 3]
        mass, center = mass + more, (mass * center + more * middle) / (mass + more)
        if name != obj:
            lower = pile[name].on[0]
            corners = outline(contacts(workspace, name, pile[name], lower, below.get(lower)))
            inside = min(inside, inside_by(corners, center[:2])) if len(corners) > 2 else -math.inf
            up = float(center[2] - workspace.bounds(name, pile[name].pose)[0][2])
            rises = min(LEFT * energy / mass, ROCKING * up)
            rocks = SURE * math.sqrt((up + rises) ** 2 - up**2) + GIVEN
            others = {other: place for other, place in below.items() if other not in pile}
            if inside < rocks and not in_equilibrium(workspace, pile, others, rocks):
                return False
        carrying = pile[name].on
        if len(carrying) != 1 or carrying[0] not in below or carrying[0] in pile:
            return True
        (name,) = carrying
        pile[name] = below[name]


def _raised(pose: Pose, height: float) -> Pose:
    """A pose, moved up by a height [m]."""
    x, y, z = pose.xyz
    return Pose((x, y, z + float(height)), pose.quat)


def _within(workspace: Workspace, obj: str, pose: Pose, others: Mapping[str, NDArray[np.float64]]) -> bool:
    """Whether an object at a pose is inside any of some others."""
    return any(
        workspace.world.overlap(obj, pose.matrix, name, T, tolerance=CONTACT_DEPTH) for name, T in others.items()
    )


EACH = 3  # which of the drops, one of so many, tell whether a grasp can let an object fall at all
SIEVING_TILTS = (20, 30, 40, 60)  # that tell whether a grasp can lay an object down at all [degrees]


def may_fall(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether a hand that puts an object down at its goal may be in its own way, and there is another way down."""
    return workspace.is_goal(obj, placement) and bool(
        drops(workspace, obj, placement) or layable(workspace, obj, placement)
    )


def letting_go(workspace: Workspace, obj: str, placement: Placement) -> list[Pose]:
    """Poses from which an object falls to its goal, the lowest first, a few that stand for all; none for another."""
    if not may_fall(workspace, obj, placement):
        return []
    above = [fall[0] for fall in drops(workspace, obj, placement)[EACH - 1 :: EACH]]
    if not layable(workspace, obj, placement):
        return above
    found = tilts(workspace, obj, placement)
    return above + [tilt.fall[0] for tilt in found if round(math.degrees(tilt.angle)) in SIEVING_TILTS]
