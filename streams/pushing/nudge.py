"""Nudging: what lies in something is pushed on a little in there, so that hands have room round it or round others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.friction_cones import friction_of
from tamp.streams.affordances.neighbours import standing_around
from tamp.streams.affordances.nudges import STEP, STEPS
from tamp.streams.context import Context
from tamp.streams.grasping.container import upright_pinches
from tamp.streams.hand.candidates import Pinches
from tamp.streams.hand.clearance import above_table, clear_of_object
from tamp.streams.hand.finger_closing import felt
from tamp.streams.pushing.hand_contact import hands_behind
from tamp.streams.pushing.push_motion import GRAZED, push_hits, pushed, sinks_into
from tamp.streams.values import Configuration, Placement, Slide
from tamp.streams.workspace import Workspace, standing
from tamp.world.scene import Scene
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DIRECTIONS = 16  # that an object is nudged in
BASE = 0.002  # surface so little above the lowest stands [m]
FIRM = 0.85  # share of what keeps an object from tipping that is counted on
HEIGHTS = (0.5, 0.7, 0.3, 0.85, 0.1)  # of the fingertips over the middle of the object, in halves of its height
PROBE, HANDS = 1, 3000  # seed and number of the hands that tell how much room there is round an object


def free_shifts(workspace: Workspace, obj: str, placement: Placement, poses: Mapping[str, Array]) -> Iterator[Array]:
    """Level ways, (3,) [m], that an object can be pushed without going into others or into a wall.

    `poses` says where the others are, T_world_object each, shape (4, 4).
    """
    world, T = workspace.world, placement.pose.matrix
    deep = {
        name: sinks_into(workspace, obj, placement, name, other) if name in placement.on else GRAZED
        for name, other in poses.items()
    }
    for angle in np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS:
        for length in STEP * np.arange(1, STEPS + 1):
            shift = length * np.array([np.cos(angle), np.sin(angle), 0.0])
            if any(world.overlap(obj, moved(T, shift), name, other, deep[name]) for name, other in poses.items()):
                break
            yield shift


def hands_over(workspace: Workspace, obj: str, placement: Placement) -> Pinches:
    """Hands that could take an object from above, were there room for them; the same for every seed."""

    def found() -> Pinches:
        rng = np.random.default_rng(PROBE)
        hands = upright_pinches(workspace, obj, placement, rng)
        hands = hands.at(above_table(workspace, hands, placement))
        hands = hands.at(np.sort(rng.permutation(len(hands))[:HANDS]))
        return hands.at(clear_of_object(workspace, obj, hands))

    return workspace.cache.value(("hands over", obj, placement), found)


def with_room(workspace: Workspace, hands: Pinches, T_world_object: Array, poses: Mapping[str, Array]) -> Pinches:
    """Those of some hands that meet none of the others around an object, neither open nor closed."""
    among = workspace.world.free_hand(Scene(dict(poses)), workspace.hand.margin)
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
    among = workspace.world.free_hand(Scene(dict(poses)), workspace.hand.margin)
    lower, upper = workspace.bounds(obj, placement.pose)
    heights = (upper[2] + lower[2]) / 2 + np.array(HEIGHTS) * (upper[2] - lower[2]) / 2
    highest = lower[2] + _tips_above(workspace, obj, placement, ahead)
    heights = heights[heights < highest]
    ways = np.outer(np.linspace(0.0, 1.0, 2 + round(float(np.linalg.norm(shift)) / STEP)), shift)
    for T, opening in hands_behind(workspace, obj, placement, ahead, heights, float(highest)):
        if not among.hits(moved(T, ways), np.full(len(ways), opening)).any():
            yield T, opening


def _tips_above(workspace: Workspace, obj: str, placement: Placement, ahead: Array) -> float:
    """How high above what it lies on an object that is pushed tips before it slides [m]: its lever over friction."""
    R, center = placement.pose.matrix[:3, :3], workspace.world.geometries[obj].center_of_mass
    from_center = (felt(workspace, obj) - center) @ R.T
    lever = (from_center[from_center[:, 2] < from_center[:, 2].min() + BASE] @ ahead).max()
    under = min((friction_of(workspace, name) for name in placement.on), default=0.0)
    return float(FIRM * lever / max(friction_of(workspace, obj) * under, 1e-9))


TRIED = 6  # hands for one nudge
STRAIGHT_UP = np.zeros(3)  # between walls there is no room to draw back


def plan_nudging(
    context: Context, obj: str, start: Placement, end: Placement
) -> Iterator[tuple[Configuration, Configuration, Slide]]:
    """Yield (first configuration, last configuration, nudge) for an object that shall be pushed to a near placement.

    All are free of what the plan has standing there, or else of what stands there now.
    """
    bound = {name: place for name, place in standing(context.bound).items() if name != obj}
    around = bound or standing_around(context.scene, obj, start)
    poses = {name: place.pose.matrix for name, place in around.items()}
    shift = np.subtract(end.pose.xyz, start.pose.xyz)
    for T, opening in islice(pushing_hands(context.scene, obj, start, shift, poses), TRIED):
        for nudge in pushed(context, obj, start, end, T, opening, STRAIGHT_UP):
            if push_hits(context.scene, nudge, around) is None:
                before = Configuration(tuple(nudge.approach[0].tolist()), opening)
                yield before, Configuration(tuple(nudge.retreat[-1].tolist()), opening), nudge
                break
