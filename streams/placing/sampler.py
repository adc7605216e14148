"""Where an object can be put: on a region of the table, on another object, inside another object; and turned how."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.stable_poses import amid, resting, righted, stands, stays, tips_at, turned
from tamp.streams.affordances.support import carried_by
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.context import Context
from tamp.streams.hand.clearance import first_clear, hand_above_table, hand_hits, opening_for
from tamp.streams.hand.firmness import unsteadiness
from tamp.streams.placing.packing import ROOM_FOR_FINGERS, crowded, packed
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace, at_pose, held, standing
from tamp.task import Pose
from tamp.task.mesh.enclosure import lies_in
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def facing(
    workspace: Workspace, obj: str, rng: np.random.Generator, draw: int, able: Callable[[Array], bool] | None = None
) -> Array:
    """A steady orientation (3, 3): as it stands now, as its goal has it, then its other steady faces, turned.

    What only leans or is held up by others as it stands now would fall over elsewhere: that is left out.

    Args:
        workspace: where the object is.
        obj: the object.
        rng: source of the faces and of the turns about the vertical.
        draw: how many came before.
        able: which of them will do, if any does; all where it is None.
    """
    geometry = workspace.world.geometries[obj]
    standing = [place.pose.matrix[:3, :3] for place in workspace.placements_of(obj)]
    known = [righted(geometry, R) for R in standing if stands(geometry, R)]
    faces = resting(workspace, obj)
    if able is not None and any(map(able, [*known, *faces])):
        known, faces = list(filter(able, known)), list(filter(able, faces))
    if known and (draw < len(known) or draw % 2 == 0 or not faces):
        R = known[draw % len(known)]
    else:
        R = faces[int(rng.integers(len(faces)))]
    # The first draws keep the object as it is turned: the grasp that fits here then fits there.
    return turned(R, 0.0 if draw < len(known) else rng.uniform(-np.pi, np.pi))


def put_down(workspace: Workspace, obj: str, grasp: Grasp | None, R: Array) -> bool:
    """Whether the hand, or any where it is not known, has room to put an object turned by R (3, 3) on the table."""

    def able() -> bool:
        place = amid(workspace, obj, R)
        return hand_above_table(workspace, place.pose, grasp) if grasp else not to_be_pushed(workspace, obj, place)

    return workspace.cache.value(("put down", obj, R.tobytes(), grasp), able)


RELEASE_HEIGHT = 0.001  # objects are let go this far above what they will stand on [m]
COMPARED = 64  # positions on a region compared at a time
FITTED = 24  # of those, the best, at which the hand is tried
DRAWS = 32  # tries before giving up
TILTED = 2.0  # what comes down so many times as far turned as is expected stands up again
EDGE = 0.01  # footprints stay this far inside the table's edge [m]


def sample_placement(context: Context, obj: str, region: str) -> Iterator[Placement]:
    """Yield placements of an object on a region of the table ("table" is all of it), without end.

    Positions with room for fingers beside everything that the plan has already placed come first, those where the
    hand that holds the object fits in before all, and, for the table as a buffer, those that no start and no goal
    will need. A region that random places would jam is filled in rows. Every third draw ignores what is known: what the
    plan has settled so far is advice, not truth.
    """
    workspace: Workspace = context.scene
    wanted = _wanted(workspace, obj) if region == TABLE else []
    draw, given = 0, set[Placement]()
    while True:
        blind = draw % 3 == 2
        grasp = None if blind else held(context.bound).get(obj)
        able = partial(put_down, workspace, obj, grasp)
        R = facing(workspace, obj, context.rng, draw if region == TABLE else 0, able)
        R = R if region == TABLE else _fitting(workspace, obj, region, R)
        draw += 1
        if not blind and context.bound and region != TABLE and crowded(workspace, workspace.region(region)):
            spot = _in_rows(context, obj, region, R, grasp, given)
            if spot is not None:
                given.add(spot)
                yield spot
                continue
            context.fail(f"the rows on {region} have no place left for {obj}")
        T = _spots(context, obj, region, R, [] if blind else _taken(context, obj) + wanted)
        if T is not None:
            best = 0 if grasp is None else first_clear(workspace, grasp, T[:FITTED], standing(context.bound), obj)
            yield Placement(Pose.from_matrix(T[best]), (TABLE,))
        else:
            context.fail(f"{obj} does not fit on {region} in this orientation")
            if draw > DRAWS:
                return


def _in_rows(
    context: Context, obj: str, region: str, R: Array, grasp: Grasp | None, given: Collection[Placement]
) -> Placement | None:
    """The next place in the rows of a region that was not given before and where the hand has room, if it is known."""
    workspace: Workspace = context.scene
    poses = packed(workspace, obj, workspace.region(region), R, grasp, _taken(context, obj))
    poses[:, 2, 3] += RELEASE_HEIGHT
    scene = Scene({name: place.pose.matrix for name, place in standing(context.bound).items() if name != obj})
    for T in poses:
        place = Placement(Pose.from_matrix(T), (TABLE,))
        if place not in given and (grasp is None or _has_room(workspace, grasp, T, scene)):
            return place
    return None


def _has_room(workspace: Workspace, grasp: Grasp, T: Array, scene: Scene) -> bool:
    """Whether the hand that lets go of an object at T (4, 4) is clear of all that stands in a scene."""
    opening = opening_for(workspace.world.robot.spec.gripper, grasp)
    return not hand_hits(workspace, T @ grasp.T_object_tool.matrix, opening, scene)


def put_aside(context: Context, obj: str, R: NDArray[np.float64], grasp: Grasp | None = None) -> Placement | None:
    """A place on the table, out of the way, for an object turned by R (3, 3); None where it does not fit on it.

    Where the grasp is given, the hand that puts it down is out of the way too if that can be.
    """
    T = _spots(context, obj, TABLE, R, _taken(context, obj) + _wanted(context.scene, obj))
    if T is None:
        return None
    best = first_clear(context.scene, grasp, T[:FITTED], standing(context.bound), obj) if grasp else 0
    return Placement(Pose.from_matrix(T[best]), (TABLE,))


def stands_then(workspace: Workspace, obj: str, grasp: Grasp, lifted: Pose, R: Array) -> bool:
    """Whether an object put down turned by R (3, 3), and by as much as it turned in the hand, does not tip over.

    `lifted`: the pose from which it was taken up.
    """
    key = ("tips at", obj, R[2].tobytes())
    tips = workspace.cache.value(key, lambda: tips_at(workspace.world.geometries[obj], R))
    return TILTED * unsteadiness(workspace, obj, grasp, lifted) < tips


def _spots(
    context: Context, obj: str, region: str, R: NDArray[np.float64], others: list[NDArray[np.float64]]
) -> NDArray[np.float64] | None:
    """Poses on a region for an object turned by R (3, 3), shape (n, 4, 4), those with room beside `others` first."""
    workspace: Workspace = context.scene
    lower, upper = _extent(workspace, obj, R)
    margins = (_room_to_tip(workspace, obj, R), EDGE) if region == TABLE else (0.0,)
    spans = (_span(workspace, obj, region, R, margin) for margin in margins)
    span = next(filter(None, spans), None) or (_middles(workspace, obj, region, R) if region != TABLE else None)
    if span is None:
        return None
    low, high = span
    xy = context.rng.uniform(low, high, size=(COMPARED, 2))
    T = np.tile(np.eye(4), (COMPARED, 1, 1))
    T[:, :3, :3] = R
    T[:, :2, 3] = xy[_ranking(workspace, xy, lower, upper, others)]
    T[:, 2, 3] = RELEASE_HEIGHT - lower[2]
    return T


def _span(workspace: Workspace, obj: str, region: str, R: Array, margin: float) -> tuple[Array, Array] | None:
    """From where to where an object turned by R (3, 3) may stand with all of it on a region; None: nowhere."""
    rect = workspace.region(region)
    center, half = np.array(rect.center), np.array(rect.size) / 2
    lower, upper = _extent(workspace, obj, R)
    low, high = center - half - lower[:2] + margin, center + half - upper[:2] - margin
    return (low, high) if (low <= high).all() else None


def _middles(workspace: Workspace, obj: str, region: str, R: Array) -> tuple[Array, Array] | None:
    """The same for what is larger than the region: its middle on that, all of it on the table."""
    rect, table = workspace.region(region), _span(workspace, obj, TABLE, R, EDGE)
    if table is None:
        return None
    lower, upper = _extent(workspace, obj, R)
    center, half = np.array(rect.center) - (lower + upper)[:2] / 2, np.array(rect.size) / 2
    low, high = np.maximum(center - half, table[0]), np.minimum(center + half, table[1])
    return (low, high) if (low <= high).all() else None


def _fitting(workspace: Workspace, obj: str, region: str, R: Array) -> Array:
    """The orientation R (3, 3), by a quarter about the vertical where the object only fits on a region like that."""
    quarter = turned(R, np.pi / 2)
    fits, fits_turned = (_span(workspace, obj, region, each, 0.0) is not None for each in (R, quarter))
    return quarter if fits_turned and not fits else R


def _room_to_tip(workspace: Workspace, obj: str, R: NDArray[np.float64]) -> float:
    """How far inside the table's edge an object turned by R (3, 3) stands, so that it lies on it where it tips over."""

    def found() -> float:
        geometry = workspace.world.geometries[obj]
        height = float(R[2] @ geometry.center_of_mass - _extent(workspace, obj, R)[0][2])
        return EDGE if stays(geometry, R) else EDGE + height

    return workspace.cache.value(("room to tip", obj, R[2].tobytes()), found)


def _taken(context: Context, obj: str) -> list[NDArray[np.float64]]:
    """Footprints of the other objects where the plan has them."""
    return [_rectangle(context.scene, f[1], f[2]) for f in at_pose(context.bound) if f[1] != obj]


def sample_stacking(context: Context, obj: str, support: str, below: Placement) -> Iterator[Placement]:
    """Yield placements of an object on top of another one that stands at `below`: over its middle first."""
    workspace: Workspace = context.scene
    for draw in range(4 * DRAWS):
        spread = 0.0 if draw == 0 else 0.25
        placement = _drop(context, workspace, obj, support, below, spread, draw)
        if placement is not None:
            yield placement


def sample_insertion(context: Context, obj: str, container: str, around: Placement) -> Iterator[Placement | None]:
    """Yield placements of an object inside another one that stands at `around`: the deepest of a few tries each.

    Where sloping walls would not carry it, it would slide to a place that nobody has planned: those come last.
    """
    workspace: Workspace = context.scene
    shape, hollow = (workspace.task.object(name).shape for name in (obj, container))
    sliding: list[Placement] = []
    for draw in range(DRAWS):
        tries = (_drop(context, workspace, obj, container, around, 0.8, 4 * draw + k) for k in range(4))
        inside = (p for p in tries if p is not None and lies_in(shape, p.pose.matrix, hollow, around.pose.matrix))
        sunk = sorted(inside, key=lambda p: p.pose.xyz[2])
        lying = next((p for p in sunk if carried_by(workspace, obj, p, container, around)), None)
        if not sunk:
            context.fail(f"{obj} does not sink into {container}")
        elif lying is None:
            context.fail(f"{container} would not carry {obj} there")
            sliding.append(sunk[0])
        yield lying
    yield from sliding


def _extent(workspace: Workspace, obj: str, R: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Bounds of the turned object about its origin, each (3,) [m]."""

    def found() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        points = workspace.points(obj) @ R.T
        return points.min(axis=0), points.max(axis=0)

    return workspace.cache.value(("extent", obj, R.tobytes()), found)


def _rectangle(workspace: Workspace, name: str, placement: Placement) -> NDArray[np.float64]:
    """Footprint of a placed object as (x_min, y_min, x_max, y_max)."""
    T = placement.pose.matrix
    lower, upper = _extent(workspace, name, T[:3, :3])
    return np.array([*(T[:2, 3] + lower[:2]), *(T[:2, 3] + upper[:2])])


def _wanted(workspace: Workspace, obj: str) -> list[NDArray[np.float64]]:
    """Footprints where objects stand at the start or shall stand at the end; a buffer keeps away from all of them."""
    placed = [*workspace.start.items(), *workspace.goals.items()]
    return [_rectangle(workspace, name, placement) for name, placement in placed if name != obj]


def _ranking(
    workspace: Workspace,
    xy: NDArray[np.float64],
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
    others: list[NDArray[np.float64]],
) -> NDArray[np.intp]:
    """Positions by room around them and by reach, best first; equal ones keep their random order."""
    spec = workspace.world.robot.spec
    base, (near, far) = np.array(spec.T_world_base.xyz[:2]), spec.reach
    distance = np.linalg.norm(xy - base, axis=1)
    cost = 10.0 * (np.maximum(near - distance, 0) + np.maximum(distance - far, 0))
    beside = np.clip(base, xy + lower[:2], xy + upper[:2])
    cost = cost + 10.0 * (np.linalg.norm(beside - base, axis=1) < spec.base_radius)
    if others:
        rect = np.array(others)
        gap_x = np.maximum(rect[:, 0] - (xy[:, :1] + upper[0]), xy[:, :1] + lower[0] - rect[:, 2])
        gap_y = np.maximum(rect[:, 1] - (xy[:, 1:] + upper[1]), xy[:, 1:] + lower[1] - rect[:, 3])
        room = np.maximum(gap_x, gap_y)
        cost = cost + np.maximum(ROOM_FOR_FINGERS - room, 0).sum(axis=1) / ROOM_FOR_FINGERS
        cost = cost + 10.0 * (room < 0.002).sum(axis=1)
    return np.argsort(cost, kind="stable")


def _drop(
    context: Context, workspace: Workspace, obj: str, support: str, below: Placement, spread: float, draw: int
) -> Placement | None:
    """Lower the object over the support until it touches; None where it slides past it to the table."""
    T_support = below.pose.matrix
    R = facing(workspace, obj, context.rng, draw // 2)
    lower, upper = _extent(workspace, obj, R)
    base_lower, base_upper = _extent(workspace, support, T_support[:3, :3])
    middle = T_support[:2, 3] + (base_lower + base_upper)[:2] / 2
    reach = spread * (base_upper - base_lower)[:2] / 2
    T = np.eye(4)
    T[:3, :3] = R
    T[:2, 3] = middle + context.rng.uniform(-reach, reach) - (lower + upper)[:2] / 2
    T[2, 3] = T_support[2, 3] + base_upper[2] - lower[2] + 0.01
    for _ in range(64):
        gap = workspace.world.separation(obj, T, support, T_support)
        if gap < 2 * RELEASE_HEIGHT:
            break
        # Lowering by the distance cannot make them touch, whatever their shapes (conservative advancement).
        T[2, 3] -= gap - RELEASE_HEIGHT
        if T[2, 3] + lower[2] < 0:
            context.fail(f"{obj} would miss {support}")
            return None
    return Placement(Pose.from_matrix(T), (support,))
