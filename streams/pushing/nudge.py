"""Nudging: what lies in something is pushed on a little in there, so that hands have room round it or round others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import standing_around
from tamp.streams.affordances.nudges import STEP, STEPS, nudged
from tamp.streams.affordances.slide_path import directions, stands, tips_above
from tamp.streams.context import Context
from tamp.streams.pushing.hand_contact import hands_behind
from tamp.streams.pushing.push_motion import GRAZED, is_refused_push, push_hits, pushed, sinks_into
from tamp.streams.values import Configuration, Placement, Slide
from tamp.streams.workspace import TABLE, Workspace, standing
from tamp.world.scene import Scene
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DIRECTIONS = 16  # that an object is nudged in
STRIDE, STRIDES = 0.02, 8  # of a push on the table [m]
HEIGHTS = (0.5, 0.7, 0.3, 0.85, 0.1)  # of the fingertips over the middle of the object, in halves of its height


def free_shifts(workspace: Workspace, obj: str, placement: Placement, poses: Mapping[str, Array]) -> Iterator[Array]:
    """Level ways, (3,) [m], that an object can be pushed without going into others, into a wall, or over an edge.

    `poses` says where the others are, T_world_object each, shape (4, 4).
    """
    world, T = workspace.world, placement.pose.matrix
    deep = {
        name: sinks_into(workspace, obj, placement, name, other) if name in placement.on else GRAZED
        for name, other in poses.items()
    }
    for heading, lengths in _headings(workspace, obj, placement):
        for length in lengths:
            shift = np.append(length * heading, 0.0)
            if any(world.overlap(obj, moved(T, shift), name, other, deep[name]) for name, other in poses.items()):
                break
            if placement.on == (TABLE,) and not stands(workspace, obj, nudged(placement, shift)):
                break
            yield shift


def _headings(workspace: Workspace, obj: str, placement: Placement) -> Iterator[tuple[Array, list[float]]]:
    """Unit vectors, (2,), in which an object may be pushed, and how far [m], rising."""
    if placement.on == (TABLE,):
        for direction in directions(workspace, obj, placement):
            yield direction.ahead, [STRIDE * count for count in range(1, STRIDES + 1)]
    else:
        for angle in np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS:
            yield np.array([np.cos(angle), np.sin(angle)]), [STEP * count for count in range(1, STEPS + 1)]


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
    highest = lower[2] + tips_above(workspace, obj, placement, ahead)
    heights = heights[heights < highest]
    ways = np.outer(np.linspace(0.0, 1.0, 2 + round(float(np.linalg.norm(shift)) / STEP)), shift)
    for T, opening in hands_behind(workspace, obj, placement, ahead, heights, float(highest)):
        if not among.hits(moved(T, ways), np.full(len(ways), opening)).any():
            yield T, opening


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
            if push_hits(context.scene, nudge, around) is None and not is_refused_push(context.scene, nudge):
                before = Configuration(tuple(nudge.approach[0].tolist()), opening)
                yield before, Configuration(tuple(nudge.retreat[-1].tolist()), opening), nudge
                break
