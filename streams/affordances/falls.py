"""Dropping: an object is let go above its placement and falls straight down, out of the opening fingers.

That is for what shall lie in something, where walls leave no room for the hand further down: they keep what falls.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import NEAR, center_at, in_equilibrium, touching
from tamp.streams.affordances.neighbours import carriers, lies_in
from tamp.streams.affordances.stable_poses import inside_by, outline
from tamp.streams.affordances.stack_balance import contacts, pile_at
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
CERTAIN = 0.002  # what holds against a blow holds too where surface only so near to it does [m]
SAME_HEIGHT = 1e-4  # heights that differ by less are one [m]
RESTS = 0.002  # surface so near to what carries rests on it [m]

Fall = tuple[Pose, ...]


def drops(workspace: Workspace, obj: str, placement: Placement) -> tuple[Fall, ...]:
    """Ways down to a placement, each the poses that the object passes, the placement's last; the shortest first.

    All are clear of what carries the object; none where it does not lie in anything, and none so high that it would
    roll or tip on where it lands.
    """
    below = carriers(workspace, obj, placement)
    key = ("drops", obj, placement, *below.items())
    found = workspace.cache.value(key, lambda: _drops(workspace, obj, placement, below))
    limit = _too_high(workspace, obj, placement)
    return tuple(fall for fall in found if fall[0].xyz[2] < limit - SAME_HEIGHT)


def learn_too_high(workspace: Workspace, obj: str, placement: Placement, let_go: Pose) -> None:
    """Let an object not fall from so high, or higher, to a placement while the pile that it joins stands as it does."""
    lower = min(let_go.xyz[2], _too_high(workspace, obj, placement))
    workspace.cache.learn(_pile_key(workspace, obj, placement), lower)


def learn_refused(workspace: Workspace, obj: str, placement: Placement, let_go: Pose) -> None:
    """Let an object not be let go tilted there again, to fall to a placement while the pile stands as it does."""
    workspace.cache.learn(("refused", let_go, _pile_key(workspace, obj, placement)), True)


def learn_jolts(workspace: Workspace, obj: str, placement: Placement, let_go: Pose) -> None:
    """Let an object not fall so far, or farther, onto the same things anywhere: what stands on them would not stay."""
    drop = min(_drop(workspace, obj, placement, let_go), _jolting_drop(workspace, obj, placement))
    workspace.cache.learn(_jolt_key(workspace, obj, placement), drop)


def refused(workspace: Workspace, obj: str, placement: Placement, let_go: Pose) -> bool:
    """Whether a fall from a pose to a placement is known to upset something."""
    if _drop(workspace, obj, placement, let_go) > _jolting_drop(workspace, obj, placement) - SAME_HEIGHT:
        return True
    return workspace.cache.value(("refused", let_go, _pile_key(workspace, obj, placement)), lambda: False)


def _too_high(workspace: Workspace, obj: str, placement: Placement) -> float:
    """The height from which an object is known to upset the pile that it falls onto [m]; endless where none is."""
    jolting = placement.pose.xyz[2] + _jolting_drop(workspace, obj, placement)
    return min(jolting, workspace.cache.value(_pile_key(workspace, obj, placement), lambda: math.inf))


def _drop(workspace: Workspace, obj: str, placement: Placement, let_go: Pose) -> float:
    """How far the centre of mass of what is let go at a pose, and may turn as it falls, comes down [m]."""
    ends = (replace(placement, pose=let_go), placement)
    above, below = (float(center_at(workspace, obj, end)[2]) for end in ends)
    return above - below


def _jolting_drop(workspace: Workspace, obj: str, placement: Placement) -> float:
    """How far an object is known to fall where what stands beside it then does not stay [m]; endless where none is."""
    return workspace.cache.value(_jolt_key(workspace, obj, placement), lambda: math.inf)


def _jolt_key(workspace: Workspace, obj: str, placement: Placement) -> Hashable:
    """An object, what it falls onto, and where the others in that pile stand."""
    pile = pile_at(obj, {**workspace.start, obj: placement})
    return "jolts", obj, placement.on, tuple(pair for pair in pile if pair[0] != obj)


def _pile_key(workspace: Workspace, obj: str, placement: Placement) -> Hashable:
    return "too high", obj, pile_at(obj, {**workspace.start, obj: placement})


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
    """Whether nothing that carries an object that falls from a height [m] onto it tips over.

    What is left of the fall may lift their common centre of mass over the edge of what carries them. It does not where
    that is far enough inside what carries each straight up, which the object itself is by `inside` [m]; else walls and
    friction may hold them.
    """
    first = _Blow({obj: placement}, *_weight(workspace, obj, placement), inside)
    energy, coming, met = first.mass * height, [first], set[tuple[str, str]]()
    while coming:
        blow = coming.pop()
        *_, name = blow.pile
        for lower in blow.pile[name].on:
            if lower not in below or lower in blow.pile or (name, lower) in met:
                continue
            met.add((name, lower))
            onto = _passed_on(workspace, blow, name, lower, below)
            up = float(onto.center[2] - workspace.bounds(lower, below[lower].pose)[0][2])
            rises = min(LEFT * energy / onto.mass, ROCKING * up)
            rocks = SURE * math.sqrt((up + rises) ** 2 - up**2) + GIVEN
            others = {other: place for other, place in below.items() if other not in onto.pile}
            struck, at = {lower: below[lower]}, {lower: onto.center}
            held = len(blow.pile[name].on) == 1 and all(
                in_equilibrium(workspace, struck, others, rocks, at, near) for near in (NEAR, CERTAIN)
            )
            if onto.inside < rocks and not held:
                return False
            coming.append(onto)
    return True


@dataclass(frozen=True, eq=False)
class _Blow:
    """What comes down on what carries it.

    Attributes:
        pile: all of it, the lowest last.
        mass: of all of it [kg].
        center: of that, or of what is below where it was met, shape (3,).
        inside: how far inside what carries each of them straight up that is [m].
    """

    pile: Mapping[str, Placement]
    mass: float
    center: NDArray[np.float64]
    inside: float


def _passed_on(workspace: Workspace, blow: _Blow, name: str, lower: str, below: Mapping[str, Placement]) -> _Blow:
    """The blow on one of those that carry a body; of several, one may be met first, and then bears all of it there."""
    center, inside = blow.center, blow.inside
    if len(blow.pile[name].on) > 1:
        points, _ = touching(workspace, name, blow.pile[name], lower, below[lower])
        center, inside = (points.mean(axis=0) if len(points) else center), math.inf
    more, middle = _weight(workspace, lower, below[lower])
    mass = blow.mass + more
    center = (blow.mass * center + more * middle) / mass
    rests = [contacts(workspace, lower, below[lower], on, below.get(on)) for on in below[lower].on]
    corners = outline(np.vstack(rests)) if rests else np.zeros((0, 2))
    inside = min(inside, inside_by(corners, center[:2])) if len(corners) > 2 else -math.inf
    return _Blow({**blow.pile, lower: below[lower]}, mass, center, inside)


def _weight(workspace: Workspace, name: str, place: Placement) -> tuple[float, NDArray[np.float64]]:
    """Mass of a body [kg], and where its centre of mass is, shape (3,)."""
    return workspace.task.object(name).mass, center_at(workspace, name, place)


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
