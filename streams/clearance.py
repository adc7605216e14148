"""The hand at a placement of the object it grasps: is there room for it, and whom does it meet?"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand import HandBoxes, boxes_in_world, clear_of_slab, hand_boxes, lowest_point, points_hit
from tamp.streams.pinches import Pinches, in_tool_frames
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Gripper, Pose
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.free_hand import FreeHand

FROM_BELOW = 0.2  # the tool's axis may point up by no more than this
TABLE_GAP = 0.002  # under the hand [m]
HAND_MARGIN = 0.002  # between the hand and what stands around [m]
PASSED = (0.015, 0.03, 0.06)  # depths below the hand at which an object that falls is looked at [m]
LEANING = 0.8  # cost of a hand that leans over by one radian
HINDERED = 10.0  # cost of a grasp that cannot serve a placement as long as its supports are there


def opening_for(gripper: Gripper, grasp: Grasp) -> float:
    """Distance between the pads before closing on a grasp [m]."""
    return min(gripper.stroke, grasp.width + 2 * grasp.clearance)


def _openings(workspace: Workspace, pinches: Pinches) -> NDArray[np.float64]:
    return np.minimum(workspace.world.robot.spec.gripper.stroke, pinches.widths + 2 * pinches.clearances)


def _boxes(workspace: Workspace) -> HandBoxes:
    if "hand" not in workspace.memory:
        workspace.memory["hand"] = hand_boxes(workspace.world.robot)
    boxes: HandBoxes = workspace.memory["hand"]
    return boxes


def above_table(workspace: Workspace, pinches: Pinches, place: Placement) -> NDArray[np.bool_]:
    """Whether the hand comes from above and stays above the table or beside it at a placement, shape (n,)."""
    clear: NDArray[np.bool_] = pinches.T_object_tool[:, :3, 2] @ place.pose.matrix[2, :3] < FROM_BELOW
    upright = np.flatnonzero(clear)
    T = place.pose.matrix @ pinches.T_object_tool[upright]
    boxes, openings, table = _boxes(workspace), _openings(workspace, pinches)[upright], workspace.task.table
    above = lowest_point(boxes, openings, T) > TABLE_GAP
    middle, half = np.array(table.center), np.array(table.size) / 2
    beside = ~above & (np.abs(T[:, :2, 3] - middle) > half).any(axis=1)
    above[beside] = clear_of_slab(boxes, openings[beside], T[beside], middle - half, middle + half, TABLE_GAP)
    clear[upright] = above
    return clear


def clear_of_object(workspace: Workspace, obj: str, pinches: Pinches) -> NDArray[np.bool_]:
    """Whether hand and open fingers are clear of the object itself, shape (n,)."""
    local = in_tool_frames(workspace.surface[obj], pinches.T_object_tool)
    return ~points_hit(_boxes(workspace), _openings(workspace, pinches), local)


def clear_of_falling(workspace: Workspace, obj: str, pinches: Pinches, let_go: Pose) -> NDArray[np.bool_]:
    """Whether the object falls out of the open hand when it is let go at a pose, clear of the fingers, shape (n,)."""
    down = let_go.matrix[2, :3]
    clear = np.ones(len(pinches), bool)
    for depth in PASSED:
        local = in_tool_frames(workspace.surface[obj] - depth * down, pinches.T_object_tool)
        clear &= ~points_hit(_boxes(workspace), _openings(workspace, pinches), local)
    return clear


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
    hand, hit = workspace.world.free_hand(supports, HAND_MARGIN), np.zeros(len(pinches), bool)
    for openings in (_openings(workspace, pinches), pinches.widths):  # fingers that close may come over a support
        lower, upper = boxes_in_world(_boxes(workspace), openings, T, HAND_MARGIN)
        near = lower[:, :, 2].min(axis=1) < 0.0
        for name in supports.poses:
            low, high = workspace.bounds(name, around[name].pose)
            near |= np.any(np.all((lower < high) & (low < upper), axis=2), axis=1)
        near &= ~hit
        hit[near] = hand.hits(T[near], openings[near])
    return HINDERED * hit


def neighbour_cost(workspace: Workspace, pinches: Pinches, obj: str, place: Placement) -> NDArray[np.float64]:
    """How many neighbours each hand would meet at a placement, shape (n,); none of those that stand on the object."""
    T, openings = place.pose.matrix @ pinches.T_object_tool, _openings(workspace, pinches)
    lower, upper = boxes_in_world(_boxes(workspace), openings, T, HAND_MARGIN)
    cost = np.zeros(len(pinches))
    around = standing_around(workspace, obj, place)
    spared = {*beneath(place, around), *standing_on(obj, around)}
    for name, other in around.items():
        low, high = workspace.bounds(name, other.pose)
        near = np.any(np.all((lower < high) & (low < upper), axis=2), axis=1)
        if name not in spared and near.any():
            points = workspace.surface[name] @ other.pose.matrix[:3, :3].T + other.pose.matrix[:3, 3]
            local = in_tool_frames(points, T[near])
            cost[near] += points_hit(_boxes(workspace), openings[near], local, HAND_MARGIN)
    return cost


def standing_on(obj: str, around: Mapping[str, Placement]) -> set[str]:
    """Those that stand on an object or on others that do: gone before it is taken, put down after it."""
    found: set[str] = set()
    while more := {name for name, place in around.items() if not {obj, *found}.isdisjoint(place.on)} - found:
        found |= more
    return found


def standing_around(workspace: Workspace, obj: str, place: Placement) -> dict[str, Placement]:
    """What stands around a placement of an object: the start scene, or the goal scene for a goal.

    What has no goal pose of its own is there as well.
    """
    around = {**workspace.start, **workspace.goals} if place is workspace.goals.get(obj) else workspace.start
    return {name: around[name] for name in sorted(around) if name != obj}


def beneath(place: Placement, around: Mapping[str, Placement]) -> list[str]:
    """Everything that carries an object at a placement, directly or through others, as it stands around; sorted."""
    found: set[str] = set()
    waiting = set(place.on)
    while waiting := (waiting & around.keys()) - found:
        found |= waiting
        waiting = {lower for name in waiting for lower in around[name].on}
    return sorted(found)


def hand_hits(workspace: Workspace, T_world_tool: NDArray[np.float64], opening: float, scene: Scene) -> bool:
    """Whether the open hand, without an arm, comes too close to the table or to anything in the scene."""
    return workspace.world.hand_contact(T_world_tool, float(opening), scene, margin=HAND_MARGIN) is not None


def hand_above_table(workspace: Workspace, pose: Pose, grasp: Grasp) -> bool:
    """Whether the open hand is clear of the table."""
    if "hand over table" not in workspace.memory:
        workspace.memory["hand over table"] = workspace.world.free_hand(Scene(), HAND_MARGIN)
    hand: FreeHand = workspace.memory["hand over table"]
    opening = opening_for(workspace.world.robot.spec.gripper, grasp)
    return not hand.hit(pose.matrix @ grasp.T_object_tool.matrix, opening)


def first_clear(
    workspace: Workspace, grasp: Grasp, poses: NDArray[np.float64], around: Mapping[str, Placement], obj: str
) -> int:
    """The first of some poses of `obj`, shape (n, 4, 4), where the hand that lets go of it is clear; 0 if none is."""
    opening = opening_for(workspace.world.robot.spec.gripper, grasp)
    scene = Scene({name: place.pose.matrix for name, place in around.items() if name != obj})
    tools = poses @ grasp.T_object_tool.matrix
    return next((i for i, tool in enumerate(tools) if not hand_hits(workspace, tool, opening, scene)), 0)
