"""Room for a hand round what lies in something, and how objects in there are nudged to make room.

The tip of the hand comes down behind an object, touches its flank above the middle and pushes it a few centimetres
straight ahead. What is pressed so near to the line through its centre of mass that friction holds it there slides along
without turning (Lynch and Mason, Stable pushing, International Journal of Robotics Research 15, 1996).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.clearance import HAND_MARGIN, above_table, clear_of_object
from tamp.streams.collisions import CONTACT_DEPTH
from tamp.streams.enclosed import enclosed, upright_pinches
from tamp.streams.fingertips import hands_behind
from tamp.streams.pinches import Pinches
from tamp.streams.poses import moved
from tamp.streams.pushing import GRAZED
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DIRECTIONS = 16  # that an object is nudged in
STEP, STEPS = 0.01, 4  # of a nudge [m]
LEVEL = 0.002  # places that differ by less in height are on one level [m]
TURN = 0.005  # half the angle between poses that differ by no turn [rad]
HEIGHTS = (0.5, 0.7, 0.3, 0.85)  # of the fingertips over the middle of the object, in halves of its height
PROBE, HANDS = 1, 3000  # seed and number of the hands that tell how much room there is round an object


def nudgeable(workspace: Workspace, obj: str, start: Placement, end: Placement) -> bool:
    """Whether one placement is so near another, on one level in the same thing, that a nudge may lead from it there."""
    shift = np.subtract(end.pose.xyz, start.pose.xyz)
    alike = start.on == end.on and abs(shift[2]) < LEVEL and abs(np.dot(start.pose.quat, end.pose.quat)) > np.cos(TURN)
    inside = len(start.on) == 1 and start.on != (TABLE,) and enclosed(workspace, obj, start)
    return alike and inside and 0.0 < float(np.linalg.norm(shift)) < STEPS * STEP + LEVEL


def nudged(placement: Placement, shift: Array) -> Placement:
    """Where an object is after it was nudged by a level shift, (3,) [m]."""
    x, y, z = np.array(placement.pose.xyz) + shift
    return Placement(Pose((float(x), float(y), float(z)), placement.pose.quat), placement.on)


def free_shifts(workspace: Workspace, obj: str, placement: Placement, poses: Mapping[str, Array]) -> Iterator[Array]:
    """Level ways, (3,) [m], that an object can be pushed without going into others or into a wall.

    `poses` says where the others are, T_world_object each, shape (4, 4).
    """
    world, T = workspace.world, placement.pose.matrix
    for angle in np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS:
        for length in STEP * np.arange(1, STEPS + 1):
            shift = length * np.array([np.cos(angle), np.sin(angle), 0.0])
            if any(
                world.overlap(obj, moved(T, shift), name, other, CONTACT_DEPTH if name in placement.on else GRAZED)
                for name, other in poses.items()
            ):
                break
            yield shift


def hands_over(workspace: Workspace, obj: str, placement: Placement) -> Pinches:
    """Hands that could take an object from above, were there room for them; the same for every seed."""
    key = ("hands over", obj, placement)
    if key not in workspace.memory:
        rng = np.random.default_rng(PROBE)
        hands = upright_pinches(workspace, obj, placement, rng)
        hands = hands.at(above_table(workspace, hands, placement))
        hands = hands.at(np.sort(rng.permutation(len(hands))[:HANDS]))
        workspace.memory[key] = hands.at(clear_of_object(workspace, obj, hands))
    found: Pinches = workspace.memory[key]
    return found


def with_room(workspace: Workspace, hands: Pinches, T_world_object: Array, poses: Mapping[str, Array]) -> Pinches:
    """Those of some hands that meet none of the others around an object, neither open nor closed."""
    among = workspace.world.free_hand(Scene(dict(poses)), HAND_MARGIN)
    stroke = workspace.world.robot.spec.gripper.stroke
    for openings in (np.minimum(stroke, hands.widths + 2 * hands.clearances), None):
        if len(hands):
            T = T_world_object @ hands.T_object_tool
            hands = hands.at(~among.hits(T, hands.widths if openings is None else openings))
    return hands


def pushing_hands(
    workspace: Workspace, obj: str, placement: Placement, shift: Array, poses: Mapping[str, Array]
) -> Iterator[tuple[Array, float]]:
    """Yield tools, (4, 4), and openings [m] with which the hand touches an object from behind to push it.

    Args:
        workspace: where it is.
        obj: the object.
        placement: where it lies.
        shift: how far it shall be pushed, (3,) [m]; only what is level of it counts.
        poses: T_world_object of all others, shape (4, 4), of which the hand stays clear.
    """
    shift = shift * (1.0, 1.0, 0.0)
    ahead = shift / np.linalg.norm(shift)
    among = workspace.world.free_hand(Scene(dict(poses)), HAND_MARGIN)
    lower, upper = workspace.bounds(obj, placement.pose)
    heights = (upper[2] + lower[2]) / 2 + np.array(HEIGHTS) * (upper[2] - lower[2]) / 2
    ways = np.outer(np.linspace(0.0, 1.0, 2 + round(float(np.linalg.norm(shift)) / STEP)), shift)
    for T, opening in hands_behind(workspace, obj, placement, ahead, heights):
        if not among.hits(moved(T, ways), np.full(len(ways), opening)).any():
            yield T, opening
