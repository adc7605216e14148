"""What it costs a hand at a placement of the object it grasps to lean, to meet what carries it, or neighbours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import beneath, standing_around, standing_on
from tamp.streams.hand.candidates import Pinches
from tamp.streams.hand.clearance import openings_of
from tamp.streams.hand.hand_boxes import boxes_in_world, hand_boxes, points_hit
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray


LEANING = 0.8  # cost of a hand that leans over by one radian
HINDERED = 10.0  # cost of a grasp that cannot serve a placement as long as its supports are there


def tilt_cost(pinches: Pinches, place: Placement) -> NDArray[np.float64]:
    """What leaning away from the vertical costs each hand at a placement, shape (n,)."""
    T = place.pose.matrix @ pinches.T_object_tool
    cost: NDArray[np.float64] = LEANING * np.arccos(np.clip(-T[:, 2, 2], -1.0, 1.0))
    return cost


def support_cost(
    workspace: Workspace, pinches: Pinches, obj: str, place: Placement, held_at: Pose | None = None
) -> NDArray[np.float64]:
    """HINDERED for each hand, open or closed, that meets what the object stands on or in and needs there, (n,).

    Where the object is let go before it gets to its placement, `held_at` says where.
    """
    around = standing_around(workspace, obj, place)
    supports = Scene(poses={name: around[name].pose.matrix for name in beneath(place, around)})
    if not supports.poses:
        return np.zeros(len(pinches))
    T = (held_at or place.pose).matrix @ pinches.T_object_tool
    hand, hit = workspace.world.free_hand(supports, workspace.hand.margin), np.zeros(len(pinches), bool)
    for openings in (openings_of(workspace, pinches), pinches.widths):  # fingers that close may come over a support
        lower, upper = boxes_in_world(hand_boxes(workspace.world.robot), openings, T, workspace.hand.margin)
        near = lower[:, :, 2].min(axis=1) < 0.0
        for name in supports.poses:
            low, high = workspace.bounds(name, around[name].pose)
            near |= np.any(np.all((lower < high) & (low < upper), axis=2), axis=1)
        near &= ~hit
        hit[near] = hand.hits(T[near], openings[near])
    return HINDERED * hit


def neighbour_cost(workspace: Workspace, pinches: Pinches, obj: str, place: Placement) -> NDArray[np.float64]:
    """How many neighbours each hand would meet at a placement, shape (n,); none of those that stand on the object."""
    T, openings = place.pose.matrix @ pinches.T_object_tool, openings_of(workspace, pinches)
    lower, upper = boxes_in_world(hand_boxes(workspace.world.robot), openings, T, workspace.hand.margin)
    cost = np.zeros(len(pinches))
    around = standing_around(workspace, obj, place)
    spared = {*beneath(place, around), *standing_on(obj, around)}
    for name, other in around.items():
        low, high = workspace.bounds(name, other.pose)
        near = np.any(np.all((lower < high) & (low < upper), axis=2), axis=1)
        if name not in spared and near.any():
            points = workspace.surface[name] @ other.pose.matrix[:3, :3].T + other.pose.matrix[:3, 3]
            boxes, margin = hand_boxes(workspace.world.robot), workspace.hand.margin
            cost[near] += points_hit(boxes, openings[near], T[near], points, margin)
    return cost
