"""Where closing fingers really stop, and whether they hold anything there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand.clearance import hand_beside
from tamp.streams.hand.rim_contact import slips_off
from tamp.streams.surfaces import SurfacePoints, surface_points
from tamp.streams.values import CLEARANCE, Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray


STOP_EARLY = 0.003  # how far the fingers may stop from where they are meant to touch [m]
WIDTH_RESOLUTION = 0.0004  # [m]
JAMMED = 0.0012  # between a pad and the object where something else has stopped the fingers [m]
LEAST_OPENING = 0.001  # fingers that let go move apart by this at least [m]
PAD_EDGE = 0.001  # the outermost part of a pad is not trusted to hold anything [m]
PAD_POINTS = 4000  # on the surface of an object that is felt for between the pads


def closed(
    workspace: Workspace, obj: str, T_object_tool: NDArray[np.float64], width: float, clearance: float = CLEARANCE
) -> Grasp | None:
    """The grasp that fingers closing on two contacts end in; None where the open hand does not fit or holds nothing.

    The pads are wider than a point: a rim or a lid beside the contacts may stop the fingers before they get there.
    Then the hand is shifted so that both fingers meet what is between the pads at the same time. Fingers that stop a
    little earlier or later open no wider for it. Pads that would slip off a slope hold nothing.

    Args:
        workspace: where the object is.
        obj: the object.
        T_object_tool: the tool in the object's frame, midway between the contacts; shape (4, 4).
        width: distance between the contacts [m].
        clearance: beside the object on each side before closing [m].
    """

    def found() -> Grasp | None:
        grasp = _closed(workspace, obj, T_object_tool, width, clearance)
        return None if grasp is None or slips_off(workspace, obj, grasp) else grasp

    return workspace.cache.value(("closed", obj, T_object_tool.tobytes(), width, clearance), found)


def _closed(
    workspace: Workspace, obj: str, T_object_tool: NDArray[np.float64], width: float, clearance: float
) -> Grasp | None:
    stop = _stop(workspace, obj, T_object_tool, width, clearance)
    if stop is None or _jams(workspace, obj, T_object_tool, stop):
        return None
    if stop - width <= STOP_EARLY:
        return Grasp(Pose.from_matrix(T_object_tool), stop, clearance - (stop - width) / 2)
    between = between_pads(workspace, obj, T_object_tool, stop)
    if not len(between):
        return None
    low, high = between.min(), between.max()
    shifted = T_object_tool.copy()
    shifted[:3, 3] += T_object_tool[:3, :3] @ np.array(workspace.world.robot.spec.gripper.axis) * (low + high) / 2
    stop = _stop(workspace, obj, shifted, high - low, clearance)
    held = stop is not None and abs(stop - (high - low)) <= STOP_EARLY and not _jams(workspace, obj, shifted, stop)
    return Grasp(Pose.from_matrix(shifted), stop, clearance) if held and stop is not None else None


def _jams(workspace: Workspace, obj: str, T_object_tool: NDArray[np.float64], stop: float) -> bool:
    """Whether links of a gripper whose fingers swing stop at an object before its pads touch it on both sides.

    Inner knuckles come closer to each other than the pads where a thick thing is held deep.
    """
    if workspace.world.robot.spec.gripper.pads is None:
        return False
    between = between_pads(workspace, obj, T_object_tool, stop)
    return not len(between) or max(stop / 2 - between.max(), stop / 2 + between.min()) > JAMMED


def _stop(
    workspace: Workspace, obj: str, T_object_tool: NDArray[np.float64], width: float, clearance: float
) -> float | None:
    """Where the closing fingers stop, looked for from `width` [m]; None where they cannot be opened from there."""
    hand = hand_beside(workspace, obj)
    stroke = workspace.world.robot.spec.gripper.stroke

    def free(opening: float) -> bool:
        return not hand.hit(T_object_tool, opening)

    low, high = width - STOP_EARLY, min(stroke, width + 2 * clearance)
    if not free(high):
        low, high = high, stroke
        if not free(high):
            return None
    while high - low > WIDTH_RESOLUTION:
        middle = (low + high) / 2
        low, high = (low, middle) if free(middle) else (middle, high)
    return high if high + LEAST_OPENING <= stroke and free(min(stroke, high + 2 * clearance)) else None


def between_pads(
    workspace: Workspace, obj: str, T_object_tool: NDArray[np.float64], width: float, edge: float = PAD_EDGE
) -> NDArray[np.float64]:
    """Where along the closing axis surface lies between pads that are `width` apart, shape (n,) [m].

    What is within `edge` [m] of a pad's outline does not count; a negative one counts what is beside it as well.
    """
    linkage = workspace.world.robot.linkage
    gripper, R_object_pads = linkage.gripper, T_object_tool[:3, :3] @ linkage.axes.T
    across, along, depth = ((felt(workspace, obj) - T_object_tool[:3, 3]) @ R_object_pads).T
    half = np.array(gripper.pad[1:]) / 2 - edge
    beyond = depth - linkage.depth(width)
    found: NDArray[np.float64] = along[(np.abs(across) < half[0]) & (np.abs(beyond) < half[1])]
    return found[np.abs(found) < width / 2 + WIDTH_RESOLUTION]


def felt(workspace: Workspace, obj: str) -> NDArray[np.float64]:
    """Many points on an object's surface in its own frame, shape (n, 3); the same for every seed."""
    return felt_surface(workspace, obj).points


def felt_surface(workspace: Workspace, obj: str) -> SurfacePoints:
    """The same with their normals."""
    parts = workspace.world.geometries[obj].parts
    return workspace.cache.value(("felt", obj), lambda: surface_points(parts, PAD_POINTS, np.random.default_rng(0)))
