"""What becomes of an object in a grasp: forces on what lies between the pads, how far it turns, swings and slips."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand.finger_closing import between_pads, closed
from tamp.streams.hand.pad_gap import FARTHEST_TURN, TURN_STEP
from tamp.streams.hand.squeezed import Squeezed, in_pads
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.task.robot import LEAST_FRICTION, PAD_FRICTION
from tamp.world.robot.payload import GRAVITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

RIMS = (0.0, 0.001)  # of a pad, which may miss what it would just meet [m]
LIFTED = 0.85  # share of what friction carries that can still be set in motion


def too_heavy(workspace: Workspace, obj: str) -> str | None:
    """Why friction carries an object in no grasp, in words; None where it does in some."""
    item, gripper = workspace.task.object(obj), workspace.world.robot.spec.gripper
    if PAD_FRICTION * item.friction < LEAST_FRICTION:
        return f"{obj} slips out of any fingers, whose friction with it is below {LEAST_FRICTION}"
    weight, carries = GRAVITY * item.mass, LIFTED * 2 * PAD_FRICTION * item.friction * gripper.force
    if weight <= carries:
        return None
    return f"{obj} weighs {weight:.1f} N, fingers carry {carries:.1f} N about by friction"


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
        return None if _angle(turn) <= FIRM else _in_hand(workspace, grasp, turn)

    return workspace.cache.value(("hanging", obj, grasp, pose), found)


def _in_hand(workspace: Workspace, grasp: Grasp, turn: Array) -> Pose:
    """How an object lies in the tool frame that has made a turn about the pads' middle, a rotation (3, 3)."""
    T_pads_object, T_pads_turned = np.eye(4), np.eye(4)
    T_pads_object[:3, :3], T_pads_object[:3, 3] = in_pads(workspace.world.robot.linkage, grasp)
    T_pads_turned[:3] = turn @ T_pads_object[:3]
    T_object_turned = np.linalg.inv(T_pads_object) @ T_pads_turned
    return grasp.T_object_tool.inverse() @ Pose.from_matrix(T_object_turned)


def _turns(squeezed: Squeezed, poses: Sequence[Pose]) -> Iterator[Array]:
    """The rotations, in the pads' frame, (3, 3), that an object makes, lifted from one pose after the other."""
    force, resisted = TRUSTED_PRESS * squeezed.force, TRUSTED_TURN * squeezed.friction * squeezed.width * TURN_STEP
    return (squeezed.turned(force, resisted, up) for up in squeezed.upward(*poses))


def askew(workspace: Workspace, obj: str, grasp: Grasp) -> bool:
    """Whether pads turn an object as they close so far that it is not where it was meant to be."""
    farthest = BULGING if _bulges(workspace, obj) else FLUSH
    return any(turn > farthest for turn in _flush(workspace, obj, grasp))


def turned_flush(workspace: Workspace, obj: str, grasp: Grasp) -> float:
    """How far pads turn an object as they close, until it lies flush between them, as the score measures it [m].

    While they slip along it friction holds less than at rest. What only the rims of the pads would stop counts as
    turned on: they may miss it.
    """
    return max(_flush(workspace, obj, grasp))


def straightened(workspace: Workspace, obj: str, grasp: Grasp) -> Grasp | None:
    """A grasp with the hand turned the way that its pads would turn the object; None where that is none.

    It is the same where they would not.
    """
    turn = next((turn for _, turn in _closing(workspace, obj, grasp) if _angle(turn) > 0.0), None)
    if turn is None:
        return grasp
    T_object_tool = _in_hand(workspace, grasp, turn).inverse().matrix.copy()
    between = between_pads(workspace, obj, T_object_tool, grasp.width)
    if not len(between):
        return None
    low, high = float(between.min()), float(between.max())
    T_object_tool[:3, 3] += T_object_tool[:3, :3] @ workspace.world.robot.spec.gripper.axis * (low + high) / 2
    return closed(workspace, obj, T_object_tool, high - low, grasp.clearance)


def _flush(workspace: Workspace, obj: str, grasp: Grasp) -> Iterator[float]:
    """How far pads turn an object as they close, as the score measures it [m], for each of their rims."""
    return (displaced for displaced, _ in _closing(workspace, obj, grasp))


def _closing(workspace: Workspace, obj: str, grasp: Grasp) -> Iterator[tuple[float, Array]]:
    """The turn that closing pads make, a rotation (3, 3), and how far it takes the object, as the score measures it.

    For each of the rims of the pads, of which the outermost part counts for nothing.
    """
    squeezed = cache(lambda: Squeezed(workspace, obj, grasp))

    def found(rim: float) -> tuple[float, Array]:
        held = squeezed()
        turn = held.turned(held.force, STICKS * held.friction * held.width * TURN_STEP, rim=rim)
        return held.displaced(turn), turn

    return (workspace.cache.value(("turned flush", obj, grasp, rim), partial(found, rim)) for rim in RIMS)


def _bulges(workspace: Workspace, obj: str) -> bool:
    """Whether an object is of several parts, which bulge beyond the surface that they stand for."""
    return len(workspace.world.geometries[obj].parts) > 1


def _angle(turn: Array) -> float:
    """By how much a rotation (3, 3) turns [rad]."""
    return math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))


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
