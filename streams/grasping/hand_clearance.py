"""What it costs a hand at a placement of the object it grasps to lean, to meet what carries it, or neighbours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import beneath, standing_around, standing_on
from tamp.streams.hand.candidates import Pinches
from tamp.streams.hand.clearance import openings_of
from tamp.streams.hand.hand_boxes import hand_boxes, near_boxes, points_hit
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray


LEANING = 0.8  # cost of a hand that leans over by one radian
UNDER_TABLE = (-np.inf, -np.inf, -np.inf), (np.inf, np.inf, 0.0)  # lower and upper corner [m]
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
    bounds = [workspace.bounds(name, around[name].pose) for name in supports.poses]
    low, high = np.array([UNDER_TABLE, *bounds]).transpose(1, 0, 2)
    for openings in (openings_of(workspace, pinches), pinches.widths):  # fingers that close may come over a support
        near = near_boxes(hand_boxes(workspace.world.robot), openings, T, workspace.hand.margin, low, high).any(axis=1)
        near &= ~hit
        hit[near] = hand.hits(T[near], openings[near])
    return HINDERED * hit


def neighbour_cost(workspace: Workspace, pinches: Pinches, obj: str, place: Placement) -> NDArray[np.float64]:
    """How many neighbours each hand would meet at a placement, shape (n,); none of those that stand on the object."""
    T, openings = place.pose.matrix @ pinches.T_object_tool, openings_of(workspace, pinches)
    around, cost = standing_around(workspace, obj, place), np.zeros(len(pinches))
    spared = {*beneath(place, around), *standing_on(obj, around)}
    others = {name: other.pose for name, other in around.items() if name not in spared}
    bounds = np.array([workspace.bounds(name, pose) for name, pose in others.items()]).reshape(-1, 2, 3)
    boxes, margin = hand_boxes(workspace.world.robot), workspace.hand.margin
    each = near_boxes(boxes, openings, T, margin, bounds[:, 0], bounds[:, 1])
    for (name, pose), near in zip(others.items(), each.T, strict=True):
        if near.any():
            points = workspace.surface[name] @ pose.matrix[:3, :3].T + pose.matrix[:3, 3]
            cost[near] += points_hit(boxes, openings[near], T[near], points, margin)
    return cost
