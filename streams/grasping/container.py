"""Pinches of what lies in something: walls leave so little room for the hand that the rare ones have to be sought.

Of all the hands that could hold a fruit in a corner of its box, one in a thousand has room there. Hands that come
straight down across a level axis have it oftenest, so many of those are drawn, and what meets a wall is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from tamp.streams.affordances.neighbours import enclosed, standing_around, standing_on, upon_carriers
from tamp.streams.affordances.tilts import upside_down
from tamp.streams.cache import recalled
from tamp.streams.context import Context
from tamp.streams.grasping.hand_clearance import neighbour_cost, support_cost
from tamp.streams.grasping.ranking import in_reach
from tamp.streams.hand.antipodal import antipodal_contacts
from tamp.streams.hand.candidates import (
    FRICTION_ANGLE,
    LEANING,
    RISES,
    SURFACE,
    TILTS,
    WIDTH_RESERVE,
    Pinches,
    hangs_over,
    levelled,
    pinches_from_above,
    sample_pinches,
)
from tamp.streams.hand.clearance import above_table, clear_of_object, opening_for
from tamp.streams.hand.finger_closing import closed
from tamp.streams.surfaces import SurfacePoints, surface_points
from tamp.streams.values import CLEARANCE, Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.kinematics.freedom import confined
from tamp.world.scene import Scene

POINTS = 1000  # on the surface, that rays start from
LEVEL, SLANTED = 0.25, 0.6  # how far a closing axis may point up, and how far where there is less room
FEW = 10  # hands with room, below which such are added
PLENTY = 60  # after which no more are sought
STRAIGHT = (0.0,)  # how a hand leans, and its axis rises, that comes straight down across a level axis [rad]
LOW, RAISED = 0.035, 0.04  # height of an object of which few hands, and few that lean over, get hold [m]
AT_ONCE = 2000  # hands that are looked at before it is seen whether there are plenty
TIGHT = 0.003  # beside the object on each side before closing, where there is less room [m]


def roomy_pinches(
    context: Context, obj: str, places: Sequence[Placement], points: int = SURFACE, turn: int = 0
) -> Pinches:
    """Pinches of an object from all around; only those with room for the hand where it lies in something.

    Walls come first, then what stands around now; where there is no room for an open hand, one that leans over and
    opens less may have some.

    Args:
        context: of the stream that is called.
        obj: the object.
        places: where it shall be grasped; its goal, above which it may be let go, is left to others.
        points: on the surface, that the rays of the first start from.
        turn: number of the round of sampling; each draws others.
    """
    workspace: Workspace = context.scene
    start, goal = workspace.start[obj], workspace.goals.get(obj)
    place = next((place for place in places if place == start or place != goal), None)
    if place is None or not enclosed(workspace, obj, place):
        return _around(workspace, obj, places, place, context.rng, points)
    roomy = alone = Pinches.none()
    walls = upon_carriers(workspace, obj, place)  # what clears them is drawn once, however often neighbours are moved
    for level, clearance in ((LEVEL, CLEARANCE), (SLANTED, TIGHT)):
        inputs = obj, place, tuple(places), points, turn, level, clearance
        draw = partial(
            _clear_inside, obj=obj, place=place, places=places, points=points, level=level, clearance=clearance
        )
        for inside in recalled(context, "inside", inputs, walls, draw):
            roomy = Pinches.joined([roomy, inside])
            # Whoever meets no neighbour either is one in many again.
            alone = Pinches.joined([alone, _clear_of_neighbours(workspace, obj, inside, place)])
            if len(alone) >= PLENTY:
                break
        if len(alone) >= FEW:
            break
    return alone if len(alone) else roomy


def _around(
    workspace: Workspace,
    obj: str,
    places: Sequence[Placement],
    place: Placement | None,
    rng: np.random.Generator,
    points: int,
) -> Pinches:
    """Pinches from all around an object that lies in nothing; above the table's edge those that are clear there."""
    hanging = place.pose if place is not None and hangs_over(workspace, obj, place) else None
    low, tilts, rises = _from_above(workspace, obj, places)
    pinches = sample_pinches(workspace, obj, rng, points, hanging, low, tilts, rises)
    if place is not None and hanging is not None:  # one in a hundred hands is clear there, and few of them in reach
        pinches = pinches.at(above_table(workspace, pinches, place))
        pinches = pinches.at(clear_of_object(workspace, obj, pinches))
    if hanging is not None and place == workspace.start[obj]:  # it may be gripped elsewhere as well
        pinches = Pinches.joined([pinches, sample_pinches(workspace, obj, rng, points)])
    return pinches


def _clear_inside(
    context: Context,
    obj: str,
    place: Placement,
    places: Sequence[Placement],
    points: int,
    level: float,
    clearance: float,
) -> Iterator[Pinches]:
    """Yield, a few of all pinches at a time, those whose hand is clear of what an object lies in at a placement.

    Args:
        context: of a sampler that sees what the object lies in, and no neighbours.
        obj: the object.
        place: where it lies in something.
        places: where it shall be grasped.
        points: on the surface, that the rays of the first start from.
        level: how far closing axes may point up that hands come straight down across.
        clearance: beside the object on each side before closing [m].
    """
    workspace: Workspace = context.scene
    low, tilts, rises = _from_above(workspace, obj, places)
    pinches = sample_pinches(workspace, obj, context.rng, points, None, low, tilts, rises)
    drawn = Pinches.joined([pinches, upright_pinches(workspace, obj, place, context.rng, level)]).opened(clearance)
    shuffled = context.rng.permutation(len(drawn))
    for first in range(0, len(drawn), AT_ONCE):
        yield _clear_of_walls(workspace, obj, drawn.at(shuffled[first : first + AT_ONCE]), place)


def _from_above(
    workspace: Workspace, obj: str, places: Sequence[Placement]
) -> tuple[list[Pose], Sequence[float], Sequence[float]]:
    """Poses of an object that lies low, how the hands lean that come down on it, and how much their axes rise [rad].

    All poses, and hands that do neither, for an arm that cannot turn its tool every way.

    With a single placement a regrasp is meant. Hands have to lean there to lay down what is turned over by that. What
    shall merely roll is held by such as do not close level; among many that do those would be lost.
    """
    if confined(workspace.world.robot):
        return [place.pose for place in places], STRAIGHT, STRAIGHT
    goal, once = workspace.goals.get(obj), len(places) > 1
    turned_over = goal is not None and upside_down(workspace, obj, goal)
    lying = all(_height(workspace, obj, place) < (LOW if once else RAISED) for place in places)
    tilts: Sequence[float] = LEANING if turned_over and not once else TILTS[:3]
    rises: Sequence[float] = (0.0,) if turned_over or once else RISES
    return [place.pose for place in places] if lying else [], tilts, rises


def _height(workspace: Workspace, obj: str, place: Placement) -> float:
    """How high an object is as it lies [m]."""
    lower, upper = workspace.bounds(obj, place.pose)
    return float(upper[2] - lower[2])


def _clear_of_walls(workspace: Workspace, obj: str, pinches: Pinches, place: Placement) -> Pinches:
    """Those whose hand stays clear of the object itself and of what it lies in."""
    pinches = pinches.at(above_table(workspace, pinches, place))
    pinches = pinches.at(support_cost(workspace, pinches, obj, place) == 0.0)  # walls leave few to look at
    return pinches.at(clear_of_object(workspace, obj, pinches))


def _clear_of_neighbours(workspace: Workspace, obj: str, pinches: Pinches, place: Placement) -> Pinches:
    """The first of those in reach that hold something while the hand meets nothing around, each as the fingers close.

    Pads that meet a rim beside the contacts shift the hand and stop farther apart than the contacts are: the open hand
    is then elsewhere and wider than it seemed, which decides among plates in a rack.
    """
    pinches = pinches.at(neighbour_cost(workspace, pinches, obj, place) == 0.0)
    pinches = pinches.at(in_reach(workspace, pinches, place.pose))
    around = standing_around(workspace, obj, place)
    kept = {name: other.pose.matrix for name, other in around.items() if name not in standing_on(obj, around)}
    hand, gripper = workspace.world.free_hand(Scene(kept), workspace.hand.margin), workspace.world.robot.spec.gripper
    openings = np.minimum(gripper.stroke, pinches.widths + 2 * pinches.clearances)
    pinches = pinches.at(~hand.hits(place.pose.matrix @ pinches.T_object_tool, openings))
    clear: dict[int, Grasp] = {}
    for index, T in enumerate(pinches.T_object_tool):
        grasp = closed(workspace, obj, T, float(pinches.widths[index]), float(pinches.clearances[index]))
        if grasp and not hand.hit(place.pose.matrix @ grasp.T_object_tool.matrix, opening_for(gripper, grasp)):
            clear[index] = grasp
        if len(clear) == PLENTY:
            break
    return replace(
        pinches.at(np.array([*clear], int)),
        T_object_tool=np.array([grasp.T_object_tool.matrix for grasp in clear.values()]).reshape(-1, 4, 4),
        widths=np.array([grasp.width for grasp in clear.values()]),
        clearances=np.array([grasp.clearance for grasp in clear.values()]),
    )


def upright_pinches(
    workspace: Workspace, obj: str, place: Placement, rng: np.random.Generator, level: float = LEVEL
) -> Pinches:
    """Pinches across axes that are level, up to so much, by hands that come down, straight or a little tilted."""
    linkage, pieces = workspace.world.robot.linkage, workspace.world.geometries[obj].parts
    down = -place.pose.matrix[2, :3]
    surface = surface_points(pieces, POINTS, rng)
    beside = np.abs(surface.normals @ down) < level
    surface = SurfacePoints(surface.points[beside], surface.normals[beside], surface.area)
    widest = linkage.gripper.stroke - WIDTH_RESERVE
    contacts = antipodal_contacts(pieces, surface, max_width=widest, friction_angle=FRICTION_ANGLE, rng=rng)
    contacts = contacts.at(np.abs(contacts.axes @ down) < level)
    if confined(workspace.world.robot):
        return pinches_from_above(levelled(contacts, -down), linkage, place.pose, STRAIGHT)
    return pinches_from_above(contacts, linkage, place.pose, TILTS)
