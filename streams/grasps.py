"""Antipodal grasps of any mesh, best first.

Candidates pinch the object between two opposite contacts from sixteen directions and at four depths. They are ranked
by what makes a grasp hold and reach: pad area in contact, leverage about the centre of mass, contact angle, upright
approach, and whether the hand is clear of table and neighbours both where the object stands and where it shall stand.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.antipodal import antipodal_contacts, surface_points
from tamp.streams.hand import HandBoxes, hand_boxes, lowest_point, points_hit
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Context, Workspace
from tamp.task import Gripper, Pose
from tamp.world.kinematics import inverse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry import Geometry

SURFACE = 400  # points that rays start from
DIRECTIONS = 16  # approach directions about the closing axis
DEPTHS = (0.018, 0.012, 0.006, 0.003)  # how far the contact lies behind the fingertips [m]
FRICTION_ANGLE = 0.35  # well inside the cone of rubber pads on plastic [rad]
CLEARANCE = 0.008  # beside the object on each side before closing [m]
WIDTH_RESERVE = 0.002  # the widest grasp leaves this much of the stroke [m]
TABLE_GAP = 0.002  # under the hand [m]
LIMIT = 160  # grasps offered for one object


@dataclass(frozen=True, eq=False)
class Candidates:
    """Grasps of one object in its own frame, in no order.

    Attributes:
        T_object_tool: shape (n, 4, 4).
        widths: shape (n,) [m].
        costs: what the object alone says against each grasp, shape (n,).
    """

    T_object_tool: NDArray[np.float64]
    widths: NDArray[np.float64]
    costs: NDArray[np.float64]


def opening_for(gripper: Gripper, grasp: Grasp) -> float:
    """Distance between the pads before closing on a grasp [m]."""
    return min(gripper.stroke, grasp.width + 2 * CLEARANCE)


def sample_grasp(context: Context, obj: str) -> Iterator[Grasp]:
    """Yield grasps of obj, best first: those that serve start and goal, then those that serve one of them."""
    workspace: Workspace = context.scene
    candidates = candidate_grasps(workspace, obj, context.rng)
    if not len(candidates.widths):
        context.fail(f"{obj} has no two opposite surfaces within the gripper's stroke")
        return
    boxes = _boxes(workspace)
    places = workspace.placements_of(obj)
    usable, burden = zip(*(_suitability(workspace, boxes, candidates, obj, place) for place in places), strict=True)
    serves = np.array(usable)
    cost = candidates.costs + np.where(serves, np.array(burden), 2.0).sum(axis=0)
    order = np.argsort(cost + 100.0 * ~serves.all(axis=0), kind="stable")
    order = order[serves[:, order].any(axis=0)]
    if not len(order):
        context.fail(f"the hand would hit the table in every grasp of {obj}")
    yield from _reachable_first(context, workspace, candidates, _spread(candidates, order), obj)


def candidate_grasps(workspace: Workspace, obj: str, rng: np.random.Generator) -> Candidates:
    """All antipodal grasps of an object that its own shape allows."""
    gripper = workspace.world.robot.spec.gripper
    geometry = workspace.world.geometries[obj]
    surface = surface_points(geometry.parts, SURFACE, rng)
    contacts = antipodal_contacts(
        geometry.parts,
        surface,
        max_width=gripper.stroke - WIDTH_RESERVE,
        friction_angle=FRICTION_ANGLE,
        rng=rng,
    )
    T, widths, depths = _frames(contacts.centers, contacts.axes, contacts.widths, gripper)
    slants = np.repeat(contacts.slants, DIRECTIONS * len(DEPTHS))
    openings = np.minimum(gripper.stroke, widths + 2 * CLEARANCE)
    T_tool_object = np.linalg.inv(T)
    points = surface.points @ T_tool_object[:, :3, :3].transpose(0, 2, 1) + T_tool_object[:, None, :3, 3]
    clear = ~points_hit(_boxes(workspace), openings, points)
    area = _pad_area(points[clear], widths[clear], surface.area, gripper)
    costs = _intrinsic_cost(T[clear], widths[clear], depths[clear], slants[clear], area, geometry, gripper)
    return Candidates(T[clear], widths[clear], costs)


def _boxes(workspace: Workspace) -> HandBoxes:
    if "hand" not in workspace.memory:
        workspace.memory["hand"] = hand_boxes(workspace.world.robot)
    boxes: HandBoxes = workspace.memory["hand"]
    return boxes


def _frames(
    centers: NDArray[np.float64], axes: NDArray[np.float64], widths: NDArray[np.float64], gripper: Gripper
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Tool frames (n, 4, 4) for every contact pair, approach direction and depth, with widths and depths (n,)."""
    closing = np.array(gripper.axis)
    side = np.cross(closing, [0.0, 0.0, 1.0])
    basis = np.stack([side, closing, [0.0, 0.0, 1.0]], axis=1)  # columns: the tool's side, closing and approach axes
    helper = np.where(np.abs(axes[:, :1]) < 0.8, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(axes, helper)
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(axes, u)
    angles = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    approach = np.cos(angles)[None, :, None] * u[:, None] + np.sin(angles)[None, :, None] * v[:, None]
    y = np.repeat(axes[:, None], DIRECTIONS, axis=1)
    R = np.stack([np.cross(y, approach), y, approach], axis=-1) @ basis.T
    tip = gripper.pad[2] / 2
    shift = np.array(DEPTHS) - tip
    n = len(centers) * DIRECTIONS * len(DEPTHS)
    T = np.tile(np.eye(4), (n, 1, 1))
    T[:, :3, :3] = np.repeat(R.reshape(-1, 3, 3), len(DEPTHS), axis=0)
    T[:, :3, 3] = (centers[:, None, None] + approach[:, :, None] * shift[None, None, :, None]).reshape(-1, 3)
    return T, np.repeat(widths, DIRECTIONS * len(DEPTHS)), np.tile(DEPTHS, len(centers) * DIRECTIONS)


def _pad_area(
    points: NDArray[np.float64], widths: NDArray[np.float64], area: float, gripper: Gripper
) -> NDArray[np.float64]:
    """Share of the smaller pad contact: surface within 1.5 mm of each pad's plane and inside its outline, (n,)."""
    closing = np.array(gripper.axis)
    along, across = points @ closing, points @ np.cross(closing, [0.0, 0.0, 1.0])
    inside = (np.abs(across) < gripper.pad[1] / 2) & (np.abs(points[:, :, 2]) < gripper.pad[2] / 2)
    first, second = (
        (inside & (np.abs(sign * along - widths[:, None] / 2) < 0.0015)).sum(axis=1) * area for sign in (-1.0, 1.0)
    )
    share: NDArray[np.float64] = np.minimum(np.minimum(first, second) / (gripper.pad[1] * gripper.pad[2]), 1.0)
    return share


def _intrinsic_cost(
    T: NDArray[np.float64],
    widths: NDArray[np.float64],
    depths: NDArray[np.float64],
    slants: NDArray[np.float64],
    area: NDArray[np.float64],
    geometry: Geometry,
    gripper: Gripper,
) -> NDArray[np.float64]:
    """What speaks against each grasp, (n,): small contact, long lever, slanted contact, shallow or wide grip."""
    lever = np.linalg.norm(T[:, :3, 3] - geometry.center_of_mass, axis=1)
    shallow = np.where(depths < 0.005, 0.6, np.where(depths < 0.01, 0.1, 0.0))
    wide = np.maximum(widths / gripper.stroke - 0.85, 0) * 2.0
    return 0.5 * (1 - area) + 6.0 * lever + slants + shallow + wide


def _suitability(
    workspace: Workspace, boxes: HandBoxes, candidates: Candidates, obj: str, place: Placement
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """For one placement: whether the hand clears the table, and how much tilt and how many neighbours it meets."""
    gripper = workspace.world.robot.spec.gripper
    T = place.pose.matrix @ candidates.T_object_tool
    openings = np.minimum(gripper.stroke, candidates.widths + 2 * CLEARANCE)
    down = -T[:, 2, 2]
    usable = (lowest_point(boxes, openings, T) > TABLE_GAP) & (down > -0.2)
    tilt = np.arccos(np.clip(down, -1.0, 1.0))
    burden = 0.4 * tilt
    chosen = np.flatnonzero(usable)
    T_tool_world = np.linalg.inv(T[chosen])
    around = workspace.goals if place is workspace.goals.get(obj) else workspace.start
    for name, other in sorted(around.items()):
        if name == obj:
            continue
        points = workspace.surface[name] @ other.pose.matrix[:3, :3].T + other.pose.matrix[:3, 3]
        if np.linalg.norm(points - place.pose.xyz, axis=1).min() > 0.3:
            continue
        local = points @ T_tool_world[:, :3, :3].transpose(0, 2, 1) + T_tool_world[:, None, :3, 3]
        burden[chosen] += 1.0 * points_hit(boxes, openings[chosen], local, margin=0.002)
    return usable, burden


def _spread(candidates: Candidates, order: NDArray[np.intp]) -> list[int]:
    """The best of every neighbourhood of similar grasps first, so that a hundred offers are not one grasp."""
    T = candidates.T_object_tool
    cells = np.concatenate(
        [np.round(T[:, :3, 3] / 0.012), np.round(T[:, :3, 2] / 0.4), np.round(T[:, :3, 0] / 0.4)], axis=1
    )
    seen: dict[bytes, int] = {}
    first, later = [], []
    for index in order.tolist():
        key = cells[index].tobytes()
        seen[key] = seen.get(key, 0) + 1
        (first if seen[key] == 1 else later).append(index)
    return (first + later)[:LIMIT]


def _reachable_first(
    context: Context, workspace: Workspace, candidates: Candidates, order: list[int], obj: str
) -> Iterator[Grasp]:
    """Yield grasps that the arm can reach at every known placement as they come; the others afterwards."""
    robot, places = workspace.world.robot, list(workspace.placements_of(obj))
    partly: list[Grasp] = []
    for index in order:
        grasp = Grasp(Pose.from_matrix(candidates.T_object_tool[index]), float(candidates.widths[index]))
        reached = [
            next(iter(inverse(robot, p.pose.matrix @ candidates.T_object_tool[index], context.rng, count=1)), None)
            for p in places
        ]
        if all(q is not None for q in reached):
            yield grasp
        elif any(q is not None for q in reached):
            partly.append(grasp)
    if not partly:
        context.fail(f"no inverse kinematics for further grasps of {obj}")
    yield from partly
