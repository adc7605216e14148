"""Room for the open hand: above the table, beside the object that it grasps, among others that stand there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand.candidates import Pinches
from tamp.streams.hand.hand_boxes import clear_of_slab, hand_boxes, points_hit
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Gripper, Pose
from tamp.world.kinematics.tilt_limit import tilt_limit
from tamp.world.scene import Scene
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.robot.hand import FreeHand


FROM_BELOW = 0.2  # beside the table the tool's axis may point up by no more than this
TABLE_GAP = 0.002  # under the hand [m]
PASSED = (0.015, 0.03, 0.06)  # depths below the hand at which an object that falls is looked at [m]
FALLING = 0.001  # between two looks at what falls past the hand that let it go [m]


def opening_for(gripper: Gripper, grasp: Grasp) -> float:
    """Distance between the pads before closing on a grasp [m]."""
    return min(gripper.stroke, grasp.width + 2 * grasp.clearance)


def openings_of(workspace: Workspace, pinches: Pinches) -> NDArray[np.float64]:
    """The same for each of many pinches, shape (n,)."""
    return np.minimum(workspace.world.robot.spec.gripper.stroke, pinches.widths + 2 * pinches.clearances)


def reach_of_hand(workspace: Workspace) -> float:
    """How far a hand reaches, at most, beyond the box around an object that it pinches, margins included [m]."""
    gripper, boxes = workspace.world.robot.spec.gripper, hand_boxes(workspace.world.robot)
    corners = np.maximum(*map(np.abs, boxes.opened(boxes.grid[1:])))
    return (
        float(np.linalg.norm(corners, axis=-1).max()) + gripper.stroke / 2 + max(gripper.depths) + workspace.hand.margin
    )


def above_table(workspace: Workspace, pinches: Pinches, place: Placement) -> NDArray[np.bool_]:
    """Whether the hand, and the arm that holds it, are above the table or beside it at a placement, shape (n,)."""
    T = place.pose.matrix @ pinches.T_object_tool
    clear = arm_above_table(workspace, T) & (T[:, 2, 2] < FROM_BELOW)
    able = np.flatnonzero(clear)
    openings, (low, high) = openings_of(workspace, pinches)[able], _table_ends(workspace)
    frames = place.pose.matrix, pinches.T_object_tool[able]
    clear[able] = clear_of_slab(hand_boxes(workspace.world.robot), openings, *frames, (low, high), TABLE_GAP)
    return clear


def arm_above_table(workspace: Workspace, T_world_tools: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the arm may be above the table or beside it while it holds each of some tools (n, 4, 4), shape (n,)."""
    limit, (low, high) = tilt_limit(workspace.world.robot), _table_ends(workspace)
    tips = T_world_tools[:, :2, 3]
    wrists = tips - limit.behind * T_world_tools[:, :2, 2]
    over = ((tips > low) & (tips < high) & (wrists > low) & (wrists < high)).all(axis=1)
    able: NDArray[np.bool_] = ~over | limit.keeps_arm_up(T_world_tools)
    return able


def _table_ends(workspace: Workspace) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The table's lower and upper ends along x and y, shape (2,) each [m]."""
    middle, half = np.array(workspace.task.table.center), np.array(workspace.task.table.size) / 2
    return middle - half, middle + half


def clear_of_object(workspace: Workspace, obj: str, pinches: Pinches) -> NDArray[np.bool_]:
    """Whether hand and open fingers are clear of the object itself, shape (n,).

    A few points on its surface tell most of those that are not; between them the hand may still be in a thin wall.
    """
    boxes, openings = hand_boxes(workspace.world.robot), openings_of(workspace, pinches)
    clear = ~points_hit(boxes, openings, pinches.T_object_tool, workspace.surface[obj])
    clear[clear] = ~hand_beside(workspace, obj).hits(pinches.T_object_tool[clear], openings[clear])
    return clear


def hand_beside(workspace: Workspace, obj: str) -> FreeHand:
    """The hand among nothing but an object, which stands at the origin."""
    return workspace.cache.value(
        ("hand beside", obj), lambda: workspace.world.free_hand(Scene({obj: np.eye(4)}), margin=0.0, ignore=(TABLE,))
    )


def clear_of_falling(workspace: Workspace, obj: str, pinches: Pinches, let_go: Pose) -> NDArray[np.bool_]:
    """Whether the object falls out of the open hand when it is let go at a pose, clear of the fingers, shape (n,)."""
    down = let_go.matrix[2, :3]
    boxes, openings = hand_boxes(workspace.world.robot), openings_of(workspace, pinches)
    passed = np.concatenate([workspace.surface[obj] - depth * down for depth in PASSED])
    return ~points_hit(boxes, openings, pinches.T_object_tool, passed)


def caught(
    workspace: Workspace, obj: str, fall: Sequence[Pose], T_world_tool: NDArray[np.float64], opening: float
) -> bool:
    """Whether an object that falls straight down meets the open hand that let it go.

    Args:
        workspace: where it falls.
        obj: the object.
        fall: poses that it passes (world frame), from where it is let go to where it lies.
        T_world_tool: where the hand stands, shape (4, 4).
        opening: distance between its pads [m].
    """
    T_tool, way = fall[0].inverse().matrix @ T_world_tool, np.subtract(fall[-1].xyz, fall[0].xyz)
    far = np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(way) / FALLING))
    passed = moved(T_tool, far[:, None] * (-way @ fall[0].matrix[:3, :3]))  # seen from the object the hand rises
    return bool(hand_beside(workspace, obj).hits(passed, np.full(len(passed), opening)).any())


def hand_hits(workspace: Workspace, T_world_tool: NDArray[np.float64], opening: float, scene: Scene) -> bool:
    """Whether the open hand, without an arm, comes too close to the table or to anything in the scene."""
    return workspace.world.hand_contact(T_world_tool, float(opening), scene, margin=workspace.hand.margin) is not None


def hand_above_table(workspace: Workspace, pose: Pose, grasp: Grasp) -> bool:
    """Whether the open hand is clear of the table."""
    hand = workspace.cache.value("hand over table", lambda: workspace.world.free_hand(Scene(), workspace.hand.margin))
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
