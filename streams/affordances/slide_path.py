"""Where an object that no hand can grasp as it lies is pushed to: over an edge of the table, or nearer to its goal.

Two fingers, apart as far as the side of the object is wide, push it straight ahead: it neither turns nor leaves them,
as its centre of mass is between the two contacts and the way goes into their cone of friction (Lynch and Mason, Stable
pushing, International Journal of Robotics Research 15, 1996).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import pad_cone, sliding_share
from tamp.streams.affordances.graspable import graspable
from tamp.streams.affordances.stable_poses import outline
from tamp.streams.affordances.support import inside_support
from tamp.streams.affordances.tilts import APART, too_wide
from tamp.streams.hand.finger_closing import felt, felt_surface
from tamp.streams.values import Placement, shifted_alone
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.robot.payload import GRAVITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLANTS = np.radians([0.0, 10.0, -10.0, 20.0, -20.0])  # of a way against the side that is pushed, where friction holds
ASLANT = 0.38  # the same against what presses on it, in space: the checker grants hardly more [rad]
FACING, FLANK = 0.7, 0.02  # what of a surface faces a direction, and is so near to the outermost, is a side of it [m]
STEADY = 0.018  # the centre of mass stays at least this far inside the table's edges [m]
FIRM, GAP = 0.012, 0.003  # and this far inside that part of its base which is on the table, within such a gap [m]
CARRIED = np.arange(1.0, 0.35, -0.1)  # shares of how far its centre lets an object hang over, the base may less
OVERHANGS = (1.0, 0.6)  # shares of the farthest that an object can hang over the edge
LEAST_OVERHANG = 0.025  # what a finger needs below and above [m]
LONGEST = 0.7  # way that is worth trying [m]
STEEPEST = 0.4  # cosine of the angle between a way and the way straight out
SIDE = 0.003  # how far behind its outermost points a side of an object reaches [m] ...
ROUND = 0.3  # ... or, where that is too narrow, how far it is turned from the one in its middle, if it is curved [rad]
LEAST_EDGE = 1e-9  # corners nearer to each other are one, and have no edge between them [m]
DIGITS = 6  # of slants in radians: what differs by less is the same
BASE = 0.002  # surface so little above the lowest stands [m]
UPRIGHT = 0.85  # share of what keeps an object from tipping that friction may take ...
SWAYING = 0.88  # ... and that it and the object's inertia may take together
LEAST_RATE = 0.05  # at which no inertia tips anything [m/s^2]
RAYS = 120  # directions in which a base's corners are sought
SQUAT = 0.8  # an object higher than this share of its width would rather tip over than slide


@dataclass(frozen=True, eq=False)
class Way:
    """A straight way for an object over the table.

    Attributes:
        end: where it leads.
        behind: unit vector out of the side that is pushed, (2,).
        touch: where the line through the centre of mass meets that side, (2,) [m].
        room: that side reaches so far to either side of there [m].
        shift: from start to end, (2,) [m].
        hanging: how far the object hangs over the edge, as a share of how far it can.
    """

    end: Placement
    behind: Array
    touch: Array
    room: float
    shift: Array
    hanging: float

    @property
    def slant(self) -> float:
        """The angle between the way and the way straight away from the side that is pushed [rad]."""
        return float(np.arccos(np.clip(-self.behind @ self.shift / np.linalg.norm(self.shift), -1.0, 1.0)))


def slidable(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether an object can be taken from a placement only after it was pushed over an edge of the table.

    That is so where it lies on the table, is wider than the hand opens, and every hand that would pinch it reaches into
    the table or would lose it.
    """

    def found() -> bool:
        flat = placement.on == (TABLE,) and too_wide(workspace, obj, placement) and squat(workspace, obj, placement)
        return flat and not graspable(workspace, obj, placement)

    return workspace.cache.value(("slidable", obj, placement), found)


def ways(workspace: Workspace, obj: str, placement: Placement) -> list[Way]:
    """Ways over the edges of the table within the arm's reach, those over which most of the object hangs first.

    Among equal ones the least slanted come first, then those that end nearest to the arm.
    """
    spec = workspace.world.robot.spec
    base = np.array(spec.T_world_base.xyz[:2])
    distance = {way: float(np.linalg.norm(way.end.pose.xyz[:2] - base)) for way in _ways(workspace, obj, placement)}
    near = [way for way in distance if distance[way] < spec.reach[1] and stands(workspace, obj, way.end)]
    return sorted(near, key=lambda way: (-way.hanging, round(way.slant, DIGITS), distance[way]))


def ways_to(workspace: Workspace, obj: str, start: Placement, end: Placement) -> list[Way]:
    """Straight ways of an object that slides rather than tips over to a placement on the table, unturned."""
    shift = np.subtract(end.pose.xyz, start.pose.xyz)[:2]
    length = float(np.linalg.norm(shift))
    if not (start.on == end.on == (TABLE,) and shifted_alone(start, end) and 0.0 < length < LONGEST):
        return []
    tips = tips_above(workspace, obj, start, np.append(shift, 0.0) / length)
    found = towards(workspace, obj, start, shift)
    return [
        Way(end, one.behind, one.touch, one.room, shift, 0.0)
        for one in found
        if _touched_up_to(workspace, obj, start, one.behind) <= tips
    ]


def stands(workspace: Workspace, obj: str, end: Placement) -> bool:
    """Whether what is left of an object's base on the table carries it: no base is all that its outline spans."""
    return inside_support(workspace, obj, end, {}, GAP) > FIRM


def squat(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether an object that is pushed would rather slide than tip over, from every side."""
    lower, upper = workspace.bounds(obj, placement.pose)
    points = workspace.points(obj) @ placement.pose.matrix[:2, :3].T
    angles = np.linspace(0.0, np.pi, 36, endpoint=False)
    along = points @ np.stack([np.cos(angles), np.sin(angles)])
    return bool(upper[2] - lower[2] < SQUAT * (along.max(axis=0) - along.min(axis=0)).min())


def tips_above(workspace: Workspace, obj: str, placement: Placement, ahead: Array) -> float:
    """How high above what it lies on an object that is pushed tips before it slides [m]: its lever over friction."""
    lever, _, _ = _base_ahead(workspace, obj, placement, ahead)
    return UPRIGHT * lever / max(sliding_share(workspace, obj, placement.on), 1e-9)


def _touched_up_to(workspace: Workspace, obj: str, placement: Placement, behind: Array) -> float:
    """How high above what it lies on upright fingers touch the side of an object that faces `behind` (2,) [m].

    That is where it reaches farthest.
    """
    points = felt(workspace, obj) @ placement.pose.matrix[:3, :3].T
    heights, out = points[:, 2] - points[:, 2].min(), points[:, :2] @ behind
    return float(heights[out > out.max() - SIDE].max())


def tipping_rate(
    workspace: Workspace, obj: str, placement: Placement, ahead: Array, lowest: float, highest: float = np.inf
) -> float:
    """How much faster or slower an object may be pushed in a second until its inertia tips it [m/s^2].

    It is pushed between `lowest` and `highest` [m], over what it lies on, and no higher than friction alone tips it.
    """
    lever, middle, top = _base_ahead(workspace, obj, placement, ahead)
    friction = sliding_share(workspace, obj, placement.on)
    highest = min(top, highest, tips_above(workspace, obj, placement, ahead))
    lowest = min(lowest, highest)
    spare = (GRAVITY * (SWAYING * lever - friction * h) / max(abs(h - middle), 1e-9) for h in (lowest, highest))
    return max(min(spare), LEAST_RATE)


def _base_ahead(workspace: Workspace, obj: str, placement: Placement, ahead: Array) -> tuple[float, float, float]:
    """How far an object's base reaches ahead of its centre of mass, and how high that and its top are over it [m].

    That is straight ahead: what is pushed aslant tips about the edge of its base that the way crosses, and not about a
    corner. Past an edge of the table nothing carries it.
    """
    R, center = placement.pose.matrix[:3, :3], workspace.world.geometries[obj].center_of_mass
    from_center = (felt(workspace, obj) - center) @ R.T
    low, high = float(from_center[:, 2].min()), float(from_center[:, 2].max())
    base = from_center[from_center[:, 2] < low + BASE]
    straight = _straight_ahead(base[:, :2], ahead[:2])
    if placement.on == (TABLE,):
        base = base[_on_table(workspace, base[:, :2] + center_from_above(workspace, obj, placement))]
    return min(float((base @ ahead).max(initial=0.0)), straight), -low, high - low


def _straight_ahead(points: Array, ahead: Array) -> float:
    """How far the convex hull of points, (n, 2), reaches along a ray from the origin [m]; infinite if not at all."""
    turned = points @ np.array([ahead, (-ahead[1], ahead[0])]).T
    angles = np.linspace(0.0, 2 * np.pi, RAYS, endpoint=False)
    corners = turned[np.unique(np.argmax(turned @ [np.cos(angles), np.sin(angles)], axis=0))]
    above, below = corners[corners[:, 1] >= 0.0], corners[corners[:, 1] <= 0.0]
    rise, fall = above[:, None, 1], -below[None, :, 1]
    share = np.divide(rise, rise + fall, out=np.zeros((len(above), len(below))), where=rise + fall > 0.0)
    crossings = (1 - share) * above[:, None, 0] + share * below[None, :, 0]
    return max(float(crossings.max()), 0.0) if crossings.size else np.inf


def _on_table(workspace: Workspace, places: Array) -> NDArray[np.bool_]:
    """Which of some places, (n, 2), the table is under, shape (n,)."""
    table = workspace.task.table
    inside: NDArray[np.bool_] = (np.abs(places - np.array(table.center)) <= np.array(table.size) / 2).all(axis=1)
    return inside


@dataclass(frozen=True, eq=False)
class Direction:
    """One in which an object can be pushed: `ahead` is a unit vector, (2,); the others are as in a way."""

    ahead: Array
    behind: Array
    touch: Array
    room: float

    def way(self, start: Placement, before: Array, length: float, hanging: float) -> Way:
        """The way of a length [m] from where the object has been shifted to from `start` before, (2,) [m]."""
        shift = length * self.ahead
        return Way(shifted(start, before + shift), self.behind, self.touch + before, self.room, shift, hanging)


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge of the table that an object may be pushed over.

    Attributes:
        outward: unit vector, (2,).
        room: from the object to the edge along it [m].
        farthest: the object can hang over so far and still stands firm, if it can at all [m].
    """

    outward: Array
    room: float
    farthest: float


def directions(workspace: Workspace, obj: str, placement: Placement) -> tuple[Direction, ...]:
    """Those in which two fingers can push an object at a placement, the widest sides first."""
    return workspace.cache.value(("directions", obj, placement), lambda: tuple(_directions(workspace, obj, placement)))


def towards(workspace: Workspace, obj: str, placement: Placement, heading: Array) -> Iterator[Direction]:
    """Those along one heading, (2,), by sides from which friction holds the object: the least slanted first."""
    ahead, known = heading / np.linalg.norm(heading), list[Direction]()
    for behind, *sides in _sides(_outline_points(workspace, obj, placement), facing=-ahead):
        slants = np.array([np.arccos(np.clip(-behind @ ahead, -1.0, 1.0))])
        new = all(behind @ other.behind < np.cos(ROUND) for other in known)
        if new and _held(workspace, obj, placement, behind, slants).any():
            found = list(_pushed(workspace, obj, placement, behind, ahead, sides))
            known += found
            yield from found


def _directions(workspace: Workspace, obj: str, placement: Placement) -> Iterator[Direction]:
    for behind, *sides in _sides(_outline_points(workspace, obj, placement)):
        for slant in SLANTS[_held(workspace, obj, placement, behind, SLANTS)]:
            yield from _pushed(workspace, obj, placement, behind, -_turned(behind, slant), sides)


def _held(workspace: Workspace, obj: str, placement: Placement, behind: Array, slants: Array) -> NDArray[np.bool_]:
    """Whether friction holds an object on two fingers that push a side so far aslant, (n,) [rad], shape (n,)."""
    steep = _steepness(workspace, obj, placement, behind)
    off = np.arccos(np.cos(slants) * np.cos(steep))  # of what presses on a flank that leans
    held: NDArray[np.bool_] = (np.abs(slants) <= pad_cone(workspace, obj)) & (off <= ASLANT)
    return held


def _pushed(
    workspace: Workspace, obj: str, placement: Placement, behind: Array, ahead: Array, sides: Sequence[Array]
) -> Iterator[Direction]:
    """The direction ahead by a side, of points (n, 2) as any of `sides` has them, if there is room for two fingers."""
    points, center = _outline_points(workspace, obj, placement), center_from_above(workspace, obj, placement)
    touch = center + ahead * float(((points - center) @ behind).max()) / (ahead @ behind)
    rooms = (_room(side - touch, behind) for side in sides)
    room = next((room for room in rooms if room >= workspace.world.robot.spec.gripper.fingertip), None)
    if room is not None:
        yield Direction(ahead, behind, touch, room)


def _room(points: Array, behind: Array) -> float:
    """How far a side, of points (n, 2), reaches to either side of the origin at least [m]."""
    across = points @ np.array([-behind[1], behind[0]])
    return float(min(across.max(), -across.min()))


def _steepness(workspace: Workspace, obj: str, placement: Placement, behind: Array) -> float:
    """How far the side of an object that is outermost in a direction, (2,), leans back there, in the middle [rad].

    Upright fingers press on one that overhangs with their flat, at its upper edge, and so level.
    """
    T, surface = placement.pose.matrix[:3, :3], felt_surface(workspace, obj)
    normals, along = surface.normals @ T.T, surface.points @ T[:2].T @ behind
    flank = (normals[:, :2] @ behind > FACING) & (along > along.max() - FLANK)
    return float(np.median(np.arcsin(np.clip(normals[flank, 2], 0.0, 1.0)))) if flank.any() else 0.0


def edges(workspace: Workspace, obj: str, placement: Placement) -> list[Edge]:
    """All four, as an object at a placement has them before it."""
    points, center = _outline_points(workspace, obj, placement), center_from_above(workspace, obj, placement)
    table = workspace.task.table
    found = []
    for outward in np.vstack([np.eye(2), -np.eye(2)]):
        reach = float(np.array(table.center) @ outward + np.array(table.size) / 2 @ np.abs(outward))
        foremost = float((points @ outward).max())
        room, most = reach - foremost, foremost - float(center @ outward) - STEADY
        over = (share * most for share in CARRIED)
        firm = (far for far in over if stands(workspace, obj, shifted(placement, (room + far) * outward)))
        found.append(Edge(outward, room, next(firm, most)))
    return found


def center_from_above(workspace: Workspace, obj: str, placement: Placement) -> Array:
    """An object's centre of mass at a placement, (2,) [m]."""
    T = placement.pose.matrix
    center: Array = (T[:3, :3] @ workspace.world.geometries[obj].center_of_mass + T[:3, 3])[:2]
    return center


def steady(workspace: Workspace, center: Array) -> bool:
    """Whether a centre of mass, (2,) [m], is far enough inside the table's edges."""
    table = workspace.task.table
    inside = np.array(table.size) / 2 - STEADY - np.abs(center - np.array(table.center))
    return bool((inside > -1e-9).all())


def _ways(workspace: Workspace, obj: str, placement: Placement) -> Iterator[Way]:
    center, around = center_from_above(workspace, obj, placement), edges(workspace, obj, placement)
    for direction in directions(workspace, obj, placement):
        for edge in around:
            rate = float(direction.ahead @ edge.outward)
            for share in OVERHANGS:
                hanging = share * edge.farthest
                length = (edge.room + hanging) / max(rate, 1e-9)
                good = rate > STEEPEST and hanging > LEAST_OVERHANG and 0.0 < length < LONGEST
                if good and steady(workspace, center + length * direction.ahead):
                    yield direction.way(placement, np.zeros(2), length, share)


def _outline_points(workspace: Workspace, obj: str, placement: Placement) -> Array:
    """Points on an object, seen from above, (n, 2) [m]."""
    T = placement.pose.matrix
    points: Array = workspace.points(obj) @ T[:2, :3].T + T[:2, 3]
    return points


def _sides(points: Array, facing: Array | None = None) -> Iterator[tuple[Array, Array, Array]]:
    """Sides of an object seen from above that differ much, the widest first; or all, those that face a direction first.

    Yields:
        outward normal (2,), the points (n, 2) that are about as far out, and all corners (m, 2) between which it is
        hardly turned: a side may be curved, as part of a plate's rim is.
    """
    corners = outline(points)
    ends = np.roll(corners, -1, axis=0)
    edges = ends - corners
    lengths = np.linalg.norm(edges, axis=1)
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.maximum(lengths, 1e-12)[:, None]
    apart, worth = (APART, lengths) if facing is None else (0.0, normals @ facing)
    kept: list[Array] = []
    for index in np.argsort(-worth, kind="stable"):
        normal = normals[index]
        if lengths[index] > LEAST_EDGE and all(normal @ other < np.cos(apart) for other in kept):
            kept.append(normal)
            curved = normals @ normal > np.cos(ROUND)
            flat = points[points @ normal > (points @ normal).max() - SIDE]
            yield normal, flat, np.concatenate([corners[curved], ends[curved]])


def _turned(vector: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    turned: Array = np.array([[c, -s], [s, c]]) @ vector
    return turned


def shifted(placement: Placement, shift: Array) -> Placement:
    """A placement shifted over the table, (2,) [m]."""
    x, y, z = placement.pose.xyz
    return Placement(Pose((x + float(shift[0]), y + float(shift[1]), z), placement.pose.quat), placement.on)
