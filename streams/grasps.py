"""Antipodal grasps of any mesh, best first.

Candidates pinch the object between two opposite contacts from sixteen directions and at four depths. They are ranked
by what makes a grasp hold and reach: pad area in contact, leverage about the centre of mass, contact angle, upright
approach, and whether the hand is clear of table and neighbours both where the object stands and where it shall stand.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.streams.antipodal import Contacts, antipodal_contacts, surface_points
from tamp.streams.hand import HandBoxes, hand_boxes, lowest_point, points_hit
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Context, Workspace
from tamp.task import Gripper, Pose
from tamp.world.kinematics import inverse
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray


SURFACE = 400  # points that rays start from
DIRECTIONS = 16  # approach directions about the closing axis
DEPTHS = (0.018, 0.012, 0.006, 0.003)  # how far the contact lies behind the fingertips [m]
ROUNDS = 6  # of sampling, where few grasps are clear at every placement
ENOUGH = 40  # clear grasps after which no further round is needed
HINDERED = 10.0  # cost of a grasp that cannot serve a placement as long as its supports are there
SIEVED = 1200  # pinches looked at closely
FROM_BELOW = 0.2  # the tool's axis may point up by no more than this
FRICTION_ANGLE = 0.35  # well inside the cone of rubber pads on plastic [rad]
CLEARANCE = 0.008  # beside the object on each side before closing [m]
WIDTH_RESERVE = 0.002  # the widest grasp leaves this much of the stroke [m]
STOP_EARLY = 0.003  # how far the fingers may stop from the contacts' own distance [m]
WIDTH_RESOLUTION = 0.0004  # [m]
TABLE_GAP = 0.002  # under the hand [m]
HAND_MARGIN = 0.002  # between the hand and what stands around [m]
PAD_SOFTNESS = 0.0015  # surface this near to a pad's plane is in contact [m]
HAND_REACH = 0.25  # neighbours farther away than this cannot meet the hand [m]
LIMIT = 160  # grasps offered for one object


@dataclass(frozen=True, eq=False)
class Pinches:
    """Many ways to pinch one object, in its own frame.

    Attributes:
        T_object_tool: shape (n, 4, 4).
        widths: distance between the pads, shape (n,) [m].
        depths: how far the contact lies behind the fingertips, shape (n,) [m].
        slants: angle between the closing axis and the surface normals, shape (n,) [rad].
    """

    T_object_tool: NDArray[np.float64]
    widths: NDArray[np.float64]
    depths: NDArray[np.float64]
    slants: NDArray[np.float64]

    def at(self, index: NDArray[Any]) -> Pinches:
        """Those at the given indices, or where a mask holds."""
        return Pinches(self.T_object_tool[index], self.widths[index], self.depths[index], self.slants[index])


def opening_for(gripper: Gripper, grasp: Grasp) -> float:
    """Distance between the pads before closing on a grasp [m]."""
    return min(gripper.stroke, grasp.width + 2 * CLEARANCE)


def sample_grasp(context: Context, obj: str) -> Iterator[Grasp]:
    """Yield grasps of obj, best first: those that serve start and goal, then those that serve one of them."""
    workspace: Workspace = context.scene
    places = list(workspace.placements_of(obj))
    found, costs = _candidates(context, workspace, obj, places)
    if len(costs):
        order = _spread(found, np.argsort(costs, kind="stable"))
        yield from _reachable_first(context, workspace, found, order, obj)


def _candidates(
    context: Context, workspace: Workspace, obj: str, places: list[Placement]
) -> tuple[Pinches, NDArray[np.float64]]:
    """Pinches and what speaks against each; sampled anew until enough of them are clear at every placement."""
    rounds: list[tuple[Pinches, NDArray[np.float64]]] = []
    for _ in range(ROUNDS):
        pinches = _pinches(workspace, obj, context.rng)
        if not len(pinches.widths):
            context.fail(f"{obj} has no two opposite surfaces within the gripper's stroke")
            continue
        pinches, serves = _over_table(workspace, pinches, places, context.rng)
        clear = _clear_of_object(workspace, obj, pinches)
        pinches, serves = pinches.at(clear), serves[:, clear]
        if not len(pinches.widths):
            context.fail(f"the hand would hit the table or {obj} itself in every grasp of {obj}")
            continue
        cost = _intrinsic_cost(workspace, obj, pinches)
        for place, usable in zip(places, serves, strict=True):
            cost += np.where(usable, _burden(workspace, pinches, obj, place), HINDERED)
        rounds.append((pinches, cost))
        if sum(int((costs < HINDERED).sum()) for _, costs in rounds) >= ENOUGH:
            break
    return _joined([pinches for pinches, _ in rounds]), np.concatenate([costs for _, costs in rounds] or [np.empty(0)])


def _joined(rounds: list[Pinches]) -> Pinches:
    if not rounds:
        return Pinches(np.empty((0, 4, 4)), np.empty(0), np.empty(0), np.empty(0))
    columns = zip(*((p.T_object_tool, p.widths, p.depths, p.slants) for p in rounds), strict=True)
    return Pinches(*(np.concatenate(column) for column in columns))


def _pinches(workspace: Workspace, obj: str, rng: np.random.Generator) -> Pinches:
    """Every antipodal contact pair of an object from directions all around at every depth."""
    gripper = workspace.world.robot.spec.gripper
    pieces = workspace.world.geometries[obj].parts
    surface = surface_points(pieces, SURFACE, rng)
    widest = gripper.stroke - WIDTH_RESERVE
    contacts = antipodal_contacts(pieces, surface, max_width=widest, friction_angle=FRICTION_ANGLE, rng=rng)
    phase = rng.uniform(0.0, 2 * np.pi / DIRECTIONS, len(contacts.widths))
    T, widths, depths = _frames(contacts, gripper, phase)
    return Pinches(T, widths, depths, np.repeat(contacts.slants, DIRECTIONS * len(DEPTHS)))


def _over_table(
    workspace: Workspace, pinches: Pinches, places: list[Placement], rng: np.random.Generator
) -> tuple[Pinches, NDArray[np.bool_]]:
    """Pinches whose hand stays above the table at one placement at least, and which placements each serves.

    Those that serve most placements are kept first: a uniform choice of a pool would lose them, since nine in ten
    of all hands reach into the table.
    """
    openings = _openings(workspace, pinches)
    serves = np.array([_above_table(workspace, pinches, openings, place) for place in places])
    order = rng.permutation(len(pinches.widths))
    order = order[np.argsort(-serves[:, order].sum(axis=0), kind="stable")]
    order = order[serves[:, order].any(axis=0)][:SIEVED]
    return pinches.at(order), serves[:, order]


def _above_table(
    workspace: Workspace, pinches: Pinches, openings: NDArray[np.float64], place: Placement
) -> NDArray[np.bool_]:
    T = place.pose.matrix @ pinches.T_object_tool
    upright: NDArray[np.bool_] = T[:, 2, 2] < FROM_BELOW
    return upright & (lowest_point(_boxes(workspace), openings, T) > TABLE_GAP)


def _clear_of_object(workspace: Workspace, obj: str, pinches: Pinches) -> NDArray[np.bool_]:
    """Whether hand and open fingers are clear of the object itself, shape (n,)."""
    local = _in_tool_frames(workspace.surface[obj], np.linalg.inv(pinches.T_object_tool))
    return ~points_hit(_boxes(workspace), _openings(workspace, pinches), local)


def _openings(workspace: Workspace, pinches: Pinches) -> NDArray[np.float64]:
    return np.minimum(workspace.world.robot.spec.gripper.stroke, pinches.widths + 2 * CLEARANCE)


def _in_tool_frames(points: NDArray[np.float64], T_tool: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (m, 3) seen from many frames (n, 4, 4); shape (n, m, 3)."""
    # Coordinates first in memory, so that each can be compared as one array.
    local = T_tool[:, :3, :3].transpose(1, 0, 2) @ points.T + T_tool[:, :3, 3].T[:, :, None]
    return local.transpose(1, 2, 0)


def _boxes(workspace: Workspace) -> HandBoxes:
    if "hand" not in workspace.memory:
        workspace.memory["hand"] = hand_boxes(workspace.world.robot)
    boxes: HandBoxes = workspace.memory["hand"]
    return boxes


def _frames(
    contacts: Contacts, gripper: Gripper, phase: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Tool frames (n, 4, 4) for every contact pair, approach direction and depth, with widths and depths (n,)."""
    axes = contacts.axes
    closing = np.array(gripper.axis)
    side = np.cross(closing, [0.0, 0.0, 1.0])
    basis = np.stack([side, closing, [0.0, 0.0, 1.0]], axis=1)  # columns: the tool's side, closing and approach axes
    helper = np.where(np.abs(axes[:, :1]) < 0.8, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(axes, helper)
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(axes, u)
    angles = phase[:, None] + np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    approach = np.cos(angles)[:, :, None] * u[:, None] + np.sin(angles)[:, :, None] * v[:, None]
    y = np.repeat(axes[:, None], DIRECTIONS, axis=1)
    R = np.stack([np.cross(y, approach), y, approach], axis=-1) @ basis.T
    shift = np.array(DEPTHS) - gripper.pad[2] / 2
    each = DIRECTIONS * len(DEPTHS)
    T = np.tile(np.eye(4), (len(axes) * each, 1, 1))
    T[:, :3, :3] = np.repeat(R.reshape(-1, 3, 3), len(DEPTHS), axis=0)
    middles = contacts.centers[:, None, None] + approach[:, :, None] * shift[None, None, :, None]
    T[:, :3, 3] = middles.reshape(-1, 3)
    return T, np.repeat(contacts.widths, each), np.tile(DEPTHS, len(axes) * DIRECTIONS)


def _intrinsic_cost(workspace: Workspace, obj: str, pinches: Pinches) -> NDArray[np.float64]:
    """What speaks against each pinch, (n,): small contact, long lever, slanted contact, shallow or wide grip."""
    gripper = workspace.world.robot.spec.gripper
    lever = np.linalg.norm(pinches.T_object_tool[:, :3, 3] - workspace.world.geometries[obj].center_of_mass, axis=1)
    shallow = np.where(pinches.depths < 0.005, 0.6, np.where(pinches.depths < 0.01, 0.1, 0.0))
    wide = np.maximum(pinches.widths / gripper.stroke - 0.85, 0) * 2.0
    return 0.5 * (1 - _pad_contact(workspace, obj, pinches)) + 6.0 * lever + pinches.slants + shallow + wide


def _pad_contact(workspace: Workspace, obj: str, pinches: Pinches) -> NDArray[np.float64]:
    """How much of the less covered pad meets surface, relative to the best pinch of the object, shape (n,)."""
    gripper = workspace.world.robot.spec.gripper
    closing = np.array(gripper.axis)
    local = _in_tool_frames(workspace.surface[obj], np.linalg.inv(pinches.T_object_tool))
    along, across = local @ closing, local @ np.cross(closing, [0.0, 0.0, 1.0])
    on_pad = (np.abs(across) < gripper.pad[1] / 2) & (np.abs(local[:, :, 2]) < gripper.pad[2] / 2)
    touched = [
        (on_pad & (np.abs(sign * along - pinches.widths[:, None] / 2) < PAD_SOFTNESS)).sum(axis=1) for sign in (-1, 1)
    ]
    least = np.minimum(*touched)
    share: NDArray[np.float64] = least / max(int(least.max()), 1)
    return share


def _burden(workspace: Workspace, pinches: Pinches, obj: str, place: Placement) -> NDArray[np.float64]:
    """What speaks against each hand at a placement, (n,): leaning over, meeting neighbours.

    Most of all it is meeting what the object stands on or in, which must be there.
    """
    T = place.pose.matrix @ pinches.T_object_tool
    burden = 0.4 * np.arccos(np.clip(-T[:, 2, 2], -1.0, 1.0))
    T_tool_world = np.linalg.inv(T)
    around = _around(workspace, obj, place)
    for name, other in around.items():
        if name in place.on:
            continue
        points = workspace.surface[name] @ other.pose.matrix[:3, :3].T + other.pose.matrix[:3, 3]
        if np.linalg.norm(points - place.pose.xyz, axis=1).min() > HAND_REACH:
            continue
        local = _in_tool_frames(points, T_tool_world)
        burden += points_hit(_boxes(workspace), _openings(workspace, pinches), local, margin=0.002)
    supports = Scene(poses={name: around[name].pose.matrix for name in place.on if name in around})
    if supports.poses:
        openings = _openings(workspace, pinches)
        burden += HINDERED * np.array(
            [_hand_hits(workspace, *hand, supports) for hand in zip(T, openings, strict=True)]
        )
    return burden


def _around(workspace: Workspace, obj: str, place: Placement) -> dict[str, Placement]:
    """What stands around a placement of an object: the start scene, or the goal scene for a goal."""
    around = workspace.goals if place is workspace.goals.get(obj) else workspace.start
    return {name: around[name] for name in sorted(around) if name != obj}


def _hand_hits(workspace: Workspace, T_world_tool: NDArray[np.float64], opening: float, scene: Scene) -> bool:
    return workspace.world.hand_contact(T_world_tool, float(opening), scene, margin=HAND_MARGIN) is not None


def _spread(pinches: Pinches, order: NDArray[np.intp]) -> list[int]:
    """The best of every neighbourhood of similar grasps first, so that a hundred offers are not one grasp."""
    T = pinches.T_object_tool
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
    context: Context, workspace: Workspace, pinches: Pinches, order: list[int], obj: str
) -> Iterator[Grasp]:
    """Yield grasps that serve every known placement as they come; afterwards the others, the less hindered first."""
    robot, places = workspace.world.robot, list(workspace.placements_of(obj))
    around = [_around(workspace, obj, place) for place in places]
    scenes = [Scene(poses={name: other.pose.matrix for name, other in others.items()}) for others in around]
    hindered: list[tuple[int, Grasp]] = []
    for index in order:
        T_tool = pinches.T_object_tool[index]
        width = _closing_width(workspace, obj, T_tool, float(pinches.widths[index]))
        if width is None:
            continue
        grasp = Grasp(Pose.from_matrix(T_tool), width)
        hindrance = 0
        for place, scene in zip(places, scenes, strict=True):
            T = place.pose.matrix @ T_tool
            opening = opening_for(robot.spec.gripper, grasp)
            if next(iter(inverse(robot, T, context.rng, count=1)), None) is None:
                hindrance += 2
            elif _hand_hits(workspace, T, opening, scene):
                hindrance += 1
        if hindrance == 0:
            yield grasp
        elif hindrance < 2 * len(places):
            hindered.append((hindrance, grasp))
    if not hindered:
        context.fail(f"no inverse kinematics for further grasps of {obj}")
    yield from (grasp for _, grasp in sorted(hindered, key=lambda pair: pair[0]))


def _closing_width(workspace: Workspace, obj: str, T_object_tool: NDArray[np.float64], width: float) -> float | None:
    """Where the closing fingers really stop [m]; None where the open hand does not fit or stops somewhere else.

    The pads are wider than a point: a rim or a lid beside the contacts may stop the fingers before they get there.
    """
    alone = Scene(poses={obj: np.eye(4)})
    world = workspace.world

    def free(opening: float) -> bool:
        return world.hand_contact(T_object_tool, opening, alone, margin=0.0, ignore=(TABLE,)) is None

    low, high = width - STOP_EARLY, min(world.robot.spec.gripper.stroke, width + 2 * CLEARANCE)
    if not free(high):
        return None
    while high - low > WIDTH_RESOLUTION:
        middle = (low + high) / 2
        low, high = (low, middle) if free(middle) else (middle, high)
    return high if high - width <= STOP_EARLY else None
