"""What becomes of an object in a grasp: forces on what lies between the pads, how far it turns, swings and slips."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.task.robot import LEAST_FRICTION, PAD_FRICTION
from tamp.world.geometry.half_spaces import half_spaces, joined
from tamp.world.robot.linkage import Linkage
from tamp.world.robot.payload import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from tamp.world.geometry.half_spaces import Planes
    from tamp.world.geometry.object_geometry import Geometry

    Array = NDArray[np.float64]

RAYS = (5, 13)  # across and along a pad, at which the object is felt
BESIDE = 0.01  # parts that are farther than this from where the pads are play no role [m]
RIMS = (0.0, 0.001)  # of a pad, which may miss what it would just meet [m]
LIFTED = 0.85  # share of what friction carries that can still be set in motion
ROUNDING = 1e-9  # [m]


class Squeezed:
    """An object in a grasp, in the frame whose axes are the pads' side, closing and approach directions.

    Attributes:
        width: how far the pads are apart [m].
        center: centre of mass, shape (3,) [m].
        weight: of the object [N].
        force: what each pad presses with [N].
        friction: the most that each pad holds along its face [N].
        across: from corner to corner of a pad [m].
    """

    def __init__(self, workspace: Workspace, obj: str, grasp: Grasp) -> None:
        item, geometry = workspace.task.object(obj), workspace.world.geometries[obj]
        gripper = workspace.world.robot.spec.gripper
        R, t = _in_pads(workspace.world.robot.linkage, grasp)
        self._R, self._pad, self.width = R, gripper.pad, grasp.width
        self.center = R @ geometry.center_of_mass + t
        self.weight = item.mass * GRAVITY
        self.force = gripper.holding_force(self.weight, item.friction)
        self.friction = PAD_FRICTION * item.friction * self.force
        self.across = math.hypot(*gripper.pad[1:])
        corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * (geometry.upper - geometry.lower).mean()
        self._cube = corners @ R.T + t
        half = np.array([gripper.pad[1], grasp.width, gripper.pad[2]]) / 2 + BESIDE
        self._pieces = workspace.cache.value(("pieces", obj), lambda: Pieces.of(geometry)).within(R, t, half)

    def displaced(self, turn: Array) -> float:
        """How far a turn about the pads' middle, a rotation (3, 3), takes the object, as the score measures it [m]."""
        return float(np.linalg.norm(self._cube @ (turn - np.eye(3)).T, axis=1).mean())

    def upward(self, *poses: Pose) -> Array:
        """The world's upward direction where the object is lifted from each of some poses, repeats left out, (n, 3)."""
        upward = {tuple(np.round(pose.matrix[2, :3], 6).tolist()) for pose in poses}
        return np.asarray(np.array(sorted(upward)) @ self._R.T)

    def apart_turned(self, turns: Array, rim: float = 0.0) -> Array:
        """How far apart the pads stand with all of it turned, for each of the rotations (n, 3, 3); shape (n,) [m].

        The outermost part of the pads, `rim` wide [m], counts for nothing.
        """
        return self._apart(turns, np.zeros((len(turns), 3)), rim)

    def apart_shifted(self, shifts: Array) -> Array:
        """The same with all of it moved, for each of the vectors (n, 3) [m]."""
        return self._apart(np.tile(np.eye(3), (len(shifts), 1, 1)), shifts, 0.0)

    def _apart(self, turns: Array, shifts: Array, rim: float) -> Array:
        origins = _rays(self._pad, rim)
        return _apart(self._pieces.planes, self._pieces.balls, origins, self.width, turns, shifts)


@lru_cache(maxsize=64)
def _rays(pad: tuple[float, float, float], rim: float) -> Array:
    """Where the rays along the closing axis begin: midway between two pads whose rims count for nothing, (r, 3) [m]."""
    sides = zip(pad[1:], RAYS, strict=True)
    across, along = (np.linspace(rim - side / 2, side / 2 - rim, count) for side, count in sides)
    return np.array([(x, 0.0, z) for x in across for z in along])


@dataclass(frozen=True, eq=False)
class Pieces:
    """The convex parts of a body, one after the other.

    Attributes:
        vertices: of all parts, shape (n, 3) [m].
        starts: where each part's vertices begin among them, shape (parts,).
        planes: of all parts.
        balls: a centre and a radius for each part, of a ball around it, shape (parts, 4) [m].
    """

    vertices: Array
    starts: NDArray[np.int64]
    planes: Planes
    balls: Array

    @staticmethod
    def of(geometry: Geometry) -> Pieces:
        """Those of a body, in its frame."""
        counts = [len(part.vertices) for part in geometry.parts]
        vertices, starts = np.concatenate([part.vertices for part in geometry.parts]), np.cumsum([0, *counts[:-1]])
        low, high = np.minimum.reduceat(vertices, starts), np.maximum.reduceat(vertices, starts)
        middles = (low + high) / 2
        reach = np.linalg.norm(vertices - np.repeat(middles, counts, axis=0), axis=1)
        balls = np.column_stack([middles, np.maximum.reduceat(reach, starts)])
        return Pieces(vertices, starts, joined(map(half_spaces, geometry.parts)), balls)

    def within(self, R: Array, t: Array, half: Array) -> Pieces:
        """Those that are, moved by R (3, 3) and t (3,), in a box about the origin, half as wide as `half` (3,) [m]."""
        moved = self.vertices @ R.T + t
        low, high = np.minimum.reduceat(moved, self.starts), np.maximum.reduceat(moved, self.starts)
        near = (low < half).all(axis=1) & (high > -half).all(axis=1)
        A, b, ends = self.planes
        counts = np.diff(ends, prepend=0)
        kept = np.repeat(near, counts)
        turned = np.ascontiguousarray(A[kept] @ R.T)
        planes = turned, b[kept] + turned @ t, np.cumsum(counts[near])
        balls = np.column_stack([self.balls[near, :3] @ R.T + t, self.balls[near, 3]])
        return replace(self, planes=planes, balls=balls)


def too_heavy(workspace: Workspace, obj: str) -> str | None:
    """Why friction carries an object in no grasp, in words; None where it does in some."""
    item, gripper = workspace.task.object(obj), workspace.world.robot.spec.gripper
    if PAD_FRICTION * item.friction < LEAST_FRICTION:
        return f"{obj} slips out of any fingers, whose friction with it is below {LEAST_FRICTION}"
    weight, carries = GRAVITY * item.mass, LIFTED * 2 * PAD_FRICTION * item.friction * gripper.force
    if weight <= carries:
        return None
    return f"{obj} weighs {weight:.1f} N, fingers carry {carries:.1f} N about by friction"


@compiled
def _apart(planes: Planes, balls: Array, origins: Array, width: float, turns: Array, shifts: Array) -> Array:
    """How far apart rays along the closing axis, from origins (r, 3), say that the pads stand, shape (n,) [m].

    Args:
        planes: of the convex parts that lie between the pads.
        balls: a centre and a radius for each part, of a ball around it, (parts, 4) [m].
        origins: where the rays begin: midway between the pads.
        width: what meets a ray farther from its beginning than half of this lies beyond the pads [m].
        turns: the parts are turned by each of these, shape (n, 3, 3),
        shifts: and then moved by these, shape (n, 3) [m].
    """
    A, b, ends = planes
    apart, turned, offset = np.empty(len(turns)), np.empty((len(A), 3)), np.empty(len(A))
    for k in range(len(turns)):
        for m in range(len(A)):
            offset[m] = b[m]
            for i in range(3):
                turned[m, i] = turns[k, i, 0] * A[m, 0] + turns[k, i, 1] * A[m, 1] + turns[k, i, 2] * A[m, 2]
                offset[m] += turned[m, i] * shifts[k, i]
        low, high, first = np.inf, -np.inf, 0
        for part in range(len(ends)):
            ball, end = balls[part], ends[part]
            x = turns[k, 0, 0] * ball[0] + turns[k, 0, 1] * ball[1] + turns[k, 0, 2] * ball[2] + shifts[k, 0]
            z = turns[k, 2, 0] * ball[0] + turns[k, 2, 1] * ball[1] + turns[k, 2, 2] * ball[2] + shifts[k, 2]
            for ray in range(len(origins)):
                if (origins[ray, 0] - x) ** 2 + (origins[ray, 2] - z) ** 2 > (ball[3] + ROUNDING) ** 2:
                    continue
                enter, leave = _crossed(turned[first:end], offset[first:end], origins[ray])
                if enter < leave and abs(enter + leave) < width + 0.002:
                    low, high = min(low, enter), max(high, leave)
            first = end
        apart[k] = max(high - low, 0.0)
    return apart


@compiled
def _crossed(A: Array, b: Array, origin: Array) -> tuple[float, float]:
    """Where a ray along y from an origin (3,) enters and leaves the body A x <= b; it leaves first where it misses."""
    enter, leave = -np.inf, np.inf
    for m in range(len(A)):
        gap = b[m] - A[m, 0] * origin[0] - A[m, 1] * origin[1] - A[m, 2] * origin[2]
        if A[m, 1] > 1e-9:
            leave = min(leave, gap / A[m, 1])
        elif A[m, 1] < -1e-9:
            enter = max(enter, gap / A[m, 1])
        elif gap < 0.0:
            return np.inf, -np.inf
        if enter >= leave:
            return np.inf, -np.inf
    return enter, leave


@lru_cache(maxsize=64)
def _axes(closing: tuple[float, float, float]) -> Array:
    """The pads' side, closing and approach directions as rows, shape (3, 3), in the tool's frame."""
    return np.stack([np.cross(closing, [0.0, 0.0, 1.0]), closing, [0.0, 0.0, 1.0]])


def _in_pads(linkage: Linkage, grasp: Grasp) -> tuple[Array, Array]:
    """Rotation and translation from the object's frame to one whose axes are the pads' side, closing and approach."""
    axes = _axes(linkage.gripper.axis)
    T = grasp.T_object_tool.inverse().matrix
    return axes @ T[:3, :3], axes @ T[:3, 3] - (0.0, 0.0, float(linkage.depth(grasp.width)))


SLIP_STEP = 0.001  # between the shifts looked at [m]
GLANCE = 3  # whoever gains nothing by so many steps at once keeps still; a slip that ends sooner does no harm
FARTHEST_SLIP = 12  # steps
WAYS = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
TRUSTED_SLIP = 0.8  # share of the friction that is counted on: of 662 grasps it told most of those that were lost


def slipping(squeezed: Squeezed, *poses: Pose) -> float:
    """How far an object slips, held by a grasp and lifted [m]; 0 where it keeps still.

    Args:
        squeezed: the object in the grasp.
        poses: where it is lifted from; the one at which it slips farthest counts.
    """
    upward = squeezed.upward(*poses)
    still = float(squeezed.apart_shifted(np.zeros((1, 3)))[0])

    def gained(ways: Array, steps: Array) -> Array:
        shifts = SLIP_STEP * ways[:, None] * steps[:, None]
        apart = squeezed.apart_shifted(shifts.reshape(-1, 3)).reshape(len(ways), len(steps))
        drawn = squeezed.weight * (shifts @ -upward.T).max(axis=2)
        energies: Array = (
            squeezed.force * (still - apart) + drawn - 2 * TRUSTED_SLIP * squeezed.friction * SLIP_STEP * steps
        )
        return energies

    ways = WAYS[gained(WAYS, np.array([float(GLANCE)]))[:, 0] > 0.0]
    if not len(ways):
        return 0.0
    return SLIP_STEP * max(map(_reached, gained(ways, np.arange(1.0, FARTHEST_SLIP + 1))))


def _reached(gained: Array) -> int:
    """How many steps it goes on, each gaining more than all before, alone or with the next two."""
    reached, most = 0, 0.0
    for count, energy in enumerate(gained, 1):
        if energy > most:
            reached, most = count, float(energy)
        elif count > reached + 2:
            break
    return reached


FIRM = 0.1  # a grasp in which the object turns by less holds it firmly [rad]
TURN_STEP = 0.04  # between the angles looked at [rad]
FARTHEST_TURN = 0.7  # it is enough to know that it turns this far [rad]
GLANCES = (1, 3, 7, 19)  # steps are looked at in stretches from one of these to the next; most end in the first
TRUSTED_TURN = 0.5  # share of the friction that is counted on: lifting shakes, and pads do not touch everywhere ...
TRUSTED_PRESS = 0.5  # ... and of what presses: of 126 grasps it told 7 of 9 that turned by over 8 degrees, all of it 1
STICKS = 0.4  # share of it that holds what pads turn as they close: the checker thinks otherwise of 4 holds in 1,000
FLUSH = 0.010  # farther than this pads must not turn what they close on, as the score measures it [m] ...
BULGING = 0.014  # ... nor what is of several parts, which bulge; the checker, which grants 2 to 4 mm more, feels more


def turning(squeezed: Squeezed, *poses: Pose) -> float:
    """The angle that an object turns by, held by a grasp and lifted [rad]; 0 where it keeps still.

    Args:
        squeezed: the object in the grasp.
        poses: where it is lifted from; the one at which it turns farthest counts.
    """
    return max(map(_angle, _turns(squeezed, poses)))


def hanging(workspace: Workspace, obj: str, grasp: Grasp, pose: Pose) -> Pose | None:
    """How an object lies in the tool frame once it is lifted from a pose by a grasp: turned, but not slipped.

    None where it keeps still, or turns by so little that it does not matter.
    """

    def found() -> Pose | None:
        (turn,) = _turns(Squeezed(workspace, obj, grasp), (pose,))
        if _angle(turn) <= FIRM:
            return None
        T_pads_object, T_pads_turned = np.eye(4), np.eye(4)
        T_pads_object[:3, :3], T_pads_object[:3, 3] = _in_pads(workspace.world.robot.linkage, grasp)
        T_pads_turned[:3] = turn @ T_pads_object[:3]
        T_object_turned = np.linalg.inv(T_pads_object) @ T_pads_turned
        return grasp.T_object_tool.inverse() @ Pose.from_matrix(T_object_turned)

    return workspace.cache.value(("hanging", obj, grasp, pose), found)


def _turns(squeezed: Squeezed, poses: Sequence[Pose]) -> Iterator[Array]:
    """The rotations, in the pads' frame, (3, 3), that an object makes, lifted from one pose after the other."""
    resisted = TRUSTED_TURN * squeezed.friction * squeezed.width * TURN_STEP

    felt: dict[bytes, Array] = {}  # wherever it is lifted from, the first turns looked at are the same

    def energies(turns: Array, up: Array) -> Array:
        key = turns.tobytes()
        if key not in felt:
            felt[key] = TRUSTED_PRESS * squeezed.force * squeezed.apart_turned(turns)
        return felt[key] + squeezed.weight * (turns @ squeezed.center @ up)

    return (_turned(partial(energies, up=up), resisted) for up in squeezed.upward(*poses))


def askew(workspace: Workspace, obj: str, grasp: Grasp) -> bool:
    """Whether pads turn an object as they close so far that it is not where it was meant to be."""
    several = len(workspace.world.geometries[obj].parts) > 1
    farthest = BULGING if several else FLUSH
    return any(_flush(workspace, obj, grasp, rim) > farthest for rim in RIMS)


def turned_flush(workspace: Workspace, obj: str, grasp: Grasp) -> float:
    """How far pads turn an object as they close, until it lies flush between them, as the score measures it [m].

    While they slip along it friction holds less than at rest. What only the rims of the pads would stop counts as
    turned on: they may miss it.
    """
    return max(_flush(workspace, obj, grasp, rim) for rim in RIMS)


def _flush(workspace: Workspace, obj: str, grasp: Grasp, rim: float) -> float:
    """The same where the outermost part of the pads, `rim` wide [m], counts for nothing."""

    def found() -> float:
        squeezed = Squeezed(workspace, obj, grasp)
        resisted = STICKS * squeezed.friction * squeezed.width * TURN_STEP
        return squeezed.displaced(_turned(lambda turns: squeezed.force * squeezed.apart_turned(turns, rim), resisted))

    return workspace.cache.value(("turned flush", obj, grasp, rim), found)


def _turned(energies: Callable[[Array], Array], resisted: float) -> Array:
    """The rotation that it makes, (3, 3); where it has turned about one axis, it may go on about the other."""
    ways = [(about, step) for about in (_about_side, _about_approach) for step in (TURN_STEP, -TURN_STEP)]
    turn, steps = np.eye(3), 1
    while steps and _angle(turn) < FARTHEST_TURN:
        still = float(energies(turn[None])[0])
        steps, turn = max((_slide(energies, turn, still, *way, resisted) for way in ways), key=itemgetter(0))
    return turn


def _slide(
    energies: Callable[[Array], Array],
    turn: Array,
    still: float,
    about: Callable[[float], Array],
    step: float,
    resisted: float,
) -> tuple[int, Array]:
    """How many steps it goes on from a rotation, each setting free more energy than it takes, alone or with the next.

    Returns:
        The number of steps, and the rotation that they lead to, shape (3, 3).
    """
    reached, least = 0, still
    for first, last in itertools.pairwise(GLANCES):
        taken = energies(np.array([about(count * step) @ turn for count in range(first, last)]))
        for count, spent in enumerate(taken, first):
            if spent + count * resisted < least:
                reached, least = count, spent + count * resisted
            elif count > reached + 1:
                return reached, about(reached * step) @ turn
    return reached, about(reached * step) @ turn


def _angle(turn: Array) -> float:
    """By how much a rotation (3, 3) turns [rad]."""
    return math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))


def _about_side(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_approach(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def swinging(squeezed: Squeezed, *poses: Pose) -> float:
    """The angle that an object turns by about the closing axis, held by a grasp and lifted [rad]; 0 where it does not.

    Pads that press with their corners alone, across from each other, resist that the most; what they do not hold then
    hangs down in the end.

    Args:
        squeezed: the object in the grasp.
        poses: where it is lifted from; the one at which it turns farthest counts.
    """
    levers = np.cross(squeezed.center, squeezed.upward(*poses))[:, 1]
    swings = squeezed.weight * np.abs(levers).max() > squeezed.friction * squeezed.across
    return FARTHEST_TURN if swings else 0.0
