"""Which pinches serve a placement of the object: as it is put down there, laid down, or let fall."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.streams.affordances.falls import letting_go
from tamp.streams.grasping.hand_clearance import HINDERED, support_cost, tilt_cost
from tamp.streams.hand.candidates import Pinches
from tamp.streams.hand.clearance import above_table, clear_of_falling
from tamp.streams.values import Placement, falls_straight
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.kinematics.inverse import approachable, reachable

if TYPE_CHECKING:
    from numpy.typing import NDArray

SIEVED = 600  # pinches that are looked at closely
FALLING = 10.0  # cost of a grasp from which the object falls straight, for each metre
REACHED_FOR = 3  # places where the hand is clear when it lets go, for which the arm is asked
SAMPLED, MOST = 6, 0.6  # where the arm gets to this share of so many pinches, it is not asked for the others
SWAPPED = 1.0  # the wrist must turn so much less, over all placements, before the fingers swap sides [rad]
LAID = 4.0  # cost of a grasp that can only lay the object down: more than that of any that puts it down


def untwisted(workspace: Workspace, pinches: Pinches, places: Sequence[Placement]) -> Pinches:
    """The pinches, with the fingers swapped where the wrist then has to turn much less from home, for all placements.

    Both hold alike, and the contacts were found in any order.
    """
    T, robot = np.array(pinches.T_object_tool, order="C"), workspace.world.robot
    home, base = np.array(robot.forward(robot.home), order="C"), np.array(robot.spec.T_world_base.xyz)
    turns = np.sum([_turns(T, place.pose.matrix, home, base) for place in places], axis=0)
    better = turns[:, 1] < turns[:, 0] - SWAPPED
    return replace(pinches, T_object_tool=np.where(better[:, None, None], T @ np.diag([-1.0, -1.0, 1.0, 1.0]), T))


@compiled
def _turns(
    T: NDArray[np.float64], pose: NDArray[np.float64], home: NDArray[np.float64], base: NDArray[np.float64]
) -> NDArray[np.float64]:
    """How far tools are turned from how the arm holds its tool at home, swung round its base, (n, 2) [rad].

    Args:
        T: the tools in an object's frame, shape (n, 4, 4); in the second column, with the fingers swapped.
        pose: of the object in the world, shape (4, 4).
        home: the tool at home in the world, shape (4, 4).
        base: of the arm, shape (3,) [m].
    """
    ahead = np.arctan2(home[1, 3] - base[1], home[0, 3] - base[0])
    turns, tool, along = np.empty((len(T), 2)), np.empty((4, 4)), np.empty(3)
    for k in range(len(T)):
        for i in range(3):
            for j in range(4):
                tool[i, j] = pose[i, 3] if j == 3 else 0.0
                for m in range(3):
                    tool[i, j] += pose[i, m] * T[k, m, j]
        swing = np.arctan2(tool[1, 3] - base[1], tool[0, 3] - base[0]) - ahead
        c, s = np.cos(swing), np.sin(swing)
        for j in range(3):  # how much each axis of the tool is along where it would be
            x, y = c * home[0, j] - s * home[1, j], s * home[0, j] + c * home[1, j]
            along[j] = tool[0, j] * x + tool[1, j] * y + tool[2, j] * home[2, j]
        for swapped, sign in enumerate((1.0, -1.0)):
            trace = sign * (along[0] + along[1]) + along[2]
            turns[k, swapped] = np.arccos(min(1.0, max(-1.0, (trace - 1.0) / 2.0)))
    return turns


def over_table(
    workspace: Workspace, obj: str, pinches: Pinches, places: Sequence[Placement], rng: np.random.Generator
) -> tuple[Pinches, NDArray[np.bool_], NDArray[np.bool_]]:
    """Pinches whose hand stays above the table at one placement at least.

    Those that serve most placements are kept first: a uniform choice of a pool would lose them, since nine in ten
    of all hands reach into the table.

    Returns:
        The pinches; which placements each serves and which it serves by laying, both of shape (places, n).
    """
    serves = np.array([above_table(workspace, pinches, place) for place in places])
    served = serves.any(axis=0)  # who serves no placement needs not be looked at closely, unless nobody serves any
    raised = np.array([[TABLE not in place.on] for place in places])  # what carries it there may be in the hand's way
    asked = (~serves | raised) & (served if served.any() else True)
    lays = np.array([_lays(workspace, obj, pinches, place, asked[i]) for i, place in enumerate(places)])
    ways = (serves | lays).sum(axis=0) + 0.5 * serves.sum(axis=0)
    order = rng.permutation(len(pinches.widths))
    order = order[np.argsort(-ways[order], kind="stable")]
    order = order[ways[order] > 0][:SIEVED]
    return pinches.at(order), serves[:, order], lays[:, order]


def placement_cost(
    workspace: Workspace,
    obj: str,
    pinches: Pinches,
    place: Placement,
    usable: NDArray[np.bool_],
    laid: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """What a placement costs each pinch, HINDERED where it cannot serve it; shape (n,).

    Args:
        workspace: where the object is.
        obj: the object.
        pinches: n ways to hold it.
        place: the placement.
        usable: which pinches serve it as far as the table says, shape (n,).
        laid: which serve it by laying the object down, or letting it fall, as far as the table says, shape (n,).
    """
    upright = np.full(len(pinches), HINDERED)
    some = pinches.at(usable)
    upright[usable] = tilt_cost(some, place) + support_cost(workspace, some, obj, place)
    free = np.flatnonzero(upright < HINDERED)
    upright[free[~in_reach(workspace, pinches.at(free), place.pose)]] = HINDERED
    falling = _fall_cost(workspace, obj, pinches, place, laid & (upright >= HINDERED))
    cost: NDArray[np.float64] = np.minimum(upright, falling)
    return cost


def _lays(
    workspace: Workspace, obj: str, pinches: Pinches, place: Placement, asked: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Whether each of the pinches asked about can let the object fall to its goal, as far as the table says, (n,)."""
    able = np.zeros(len(pinches), bool)
    for let_go in letting_go(workspace, obj, place):
        rest = np.flatnonzero(asked & ~able)
        able[rest] = above_table(workspace, pinches.at(rest), Placement(let_go, place.on))
    return able


def _fall_cost(
    workspace: Workspace, obj: str, pinches: Pinches, place: Placement, asked: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """What it costs each of the pinches asked about to let the object fall to its goal, HINDERED where it cannot, (n,).

    The hand must be in reach, clear of what carries the object, and of the object on its way straight down.
    """
    cost, tried = np.full(len(pinches), HINDERED), np.zeros(len(pinches), int)
    for let_go in letting_go(workspace, obj, place):
        rest = np.flatnonzero(asked & (cost >= HINDERED) & (tried < REACHED_FOR))
        rest = rest[above_table(workspace, pinches.at(rest), Placement(let_go, place.on))]
        straight = falls_straight(let_go, place.pose)
        if straight:
            rest = rest[clear_of_falling(workspace, obj, pinches.at(rest), let_go)]
        rest = rest[support_cost(workspace, pinches.at(rest), obj, place, let_go) < HINDERED]
        tried[rest] += 1
        rest = rest[in_reach(workspace, pinches.at(rest), let_go)]
        cost[rest] = LAID + (FALLING * (let_go.xyz[2] - place.pose.xyz[2]) if straight else 0.0)
    return cost


def in_reach(workspace: Workspace, pinches: Pinches, pose: Pose) -> NDArray[np.bool_]:
    """Whether the arm gets to each of the pinches of an object at a pose, and back from it, as a glance says, (n,).

    Where it gets to most of a few, all are taken for reached: inverse kinematics finds out the others sooner.
    """
    robot, T = workspace.world.robot, pose.matrix @ pinches.T_object_tool
    few = T[:: -(-len(T) // SAMPLED)] if len(T) > 2 * SAMPLED else T[:0]
    if len(few) and reachable(robot, few, hurried=True).mean() >= MOST:
        return np.ones(len(T), bool)
    return approachable(robot, T, min(workspace.hand.approaches))
