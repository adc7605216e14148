"""Filling a region that random places would jam: bottom-left packing with room for the fingers between the objects.

Objects turned parallel to the region stand side by side in rows: at the points of a lattice or beside one another, each
as far into one corner of the region as the others leave it, after Baker, Coffman and Rivest (Orthogonal packings in two
dimensions, SIAM J. Comput. 9, 1980). Along one axis of the region the fingers have room beside each object, along the
other one the objects stand close.

Rectangles put down at random cover little more than half of a region before no further one fits (Palasti, On some
random space filling problems, 1960); rows cover nearly all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.stable_poses import outline, turned
from tamp.streams.values import Grasp
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import On, Region

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROOM_FOR_FINGERS = 0.035  # wanted between an object and its neighbours [m]
CLOSE = 0.005  # between neighbours where no finger goes [m]
SPACINGS = (2.0, 1.7, 1.4, 1.2, 1.1, 1.0, 0.9)  # by which both are multiplied: the widest that fits everything
LOOSE = 0.5  # of a region is covered, room for fingers included, where random places begin to jam
SAME = 1e-5  # coordinates that differ by less are one [m]


@dataclass(frozen=True)
class Rows:
    """How a region is filled.

    Attributes:
        axis: of the region along which the fingers close, 0 or 1.
        gaps: between neighbours along x and y [m].
    """

    axis: int
    gaps: tuple[float, float]


def crowded(workspace: Workspace, region: Region) -> bool:
    """Whether all that shall stand on a region in the end, more than one object, needs it filled in rows."""
    names, staying = _claims(workspace, region)

    def full() -> bool:
        sides = [_sides(workspace, name) for name in names] + [upper - lower for lower, upper in staying]
        wanted = sum(float(np.prod(side + ROOM_FOR_FINGERS)) for side in sides)
        return len(names) > 1 and wanted > LOOSE * float(np.prod(np.array(region.size) + ROOM_FOR_FINGERS))

    return workspace.cache.value(("crowded", region, names, len(staying)), full)


def packed(
    workspace: Workspace, obj: str, region: Region, R: Array, grasp: Grasp | None, others: Sequence[Array]
) -> Array:
    """Poses of an object in the rows of a region, farthest into its corner first.

    Args:
        workspace: where the region is.
        obj: the object.
        region: to be filled.
        R: a steady orientation of it, shape (3, 3), which is turned parallel to the region.
        grasp: the hand that puts it down, None where it is not known; its fingers close along the rows' axis.
        others: footprints of what stands there, (x_min, y_min, x_max, y_max) each [m].

    Returns:
        Poses on the table, shape (n, 4, 4); each place comes twice, the second time turned by half a turn.
    """
    way = rows(workspace, region)
    found: list[Array] = []
    turns = _turns(workspace, obj, R, grasp, way.axis)
    lower, upper = _bounds(workspace.points(obj) @ turns[0].T)
    corners = _corners(region, way, (upper - lower)[:2], np.array(others).reshape(-1, 4))
    for corner in corners[_order(workspace, region, way, corners + (upper - lower)[:2] / 2)]:
        for turn in turns:
            low, _ = _bounds(workspace.points(obj) @ turn.T)
            T = np.eye(4)
            T[:3, :3], T[:2, 3], T[2, 3] = turn, corner - low[:2], -low[2]
            found.append(T)
    return np.array(found).reshape(-1, 4, 4)


def rows(workspace: Workspace, region: Region) -> Rows:
    """The widest rows in which all that a region shall hold fits on it, the narrowest where none do."""
    names, staying = _claims(workspace, region)

    def found() -> Rows:
        sides = [_sides(workspace, name) for name in names]
        taken = [np.concatenate(each) for each in staying]
        ways = [_spaced(axis, scale) for scale in SPACINGS for axis in (0, 1)]
        return next((way for way in ways if _all_fit(region, way, sides, taken)), ways[-1])

    return workspace.cache.value(("rows", region, names, len(staying)), found)


def _spaced(axis: int, scale: float) -> Rows:
    wide, close = scale * ROOM_FOR_FINGERS, scale * CLOSE
    return Rows(axis, (wide, close) if axis == 0 else (close, wide))


def _claims(workspace: Workspace, region: Region) -> tuple[tuple[str, ...], list[tuple[Array, Array]]]:
    """Objects that shall stand on a region, and what those cover of it that stand there and need not leave."""
    goals = {obj.name: obj.goal for obj in workspace.whole.objects}
    names = tuple(name for name, goal in goals.items() if isinstance(goal, On) and goal.target == region.name)
    middle, half = np.array(region.center), np.array(region.size) / 2
    staying = []
    for name, place in workspace.start.items():
        if goals[name] is None and place.on == (TABLE,):
            lower, upper = (corner[:2] for corner in workspace.bounds(name, place.pose))
            lower, upper = np.maximum(lower, middle - half), np.minimum(upper, middle + half)
            if (lower < upper).all():
                staying.append((lower, upper))
    return names, staying


def _all_fit(region: Region, way: Rows, sides: Sequence[Array], taken: Sequence[Array]) -> bool:
    """Whether rectangles of these sides, shape (2,) each, the narrow one first, fit on a region beside others."""
    others = list(taken)
    for side in sides:
        size = side if way.axis == 0 else side[::-1]
        corners = _corners(region, way, size, np.array(others).reshape(-1, 4))
        if not len(corners):
            return False
        corner = corners[np.lexsort((corners[:, 1 - way.axis], corners[:, way.axis]))[0]]
        others.append(np.concatenate([corner, corner + size]))
    return True


def _corners(region: Region, way: Rows, size: Array, others: Array) -> Array:
    """Lower corners (n, 2) at which a rectangle fits on a region: in a lattice, and beside each of `others` (k, 4)."""
    middle, half = np.array(region.center), np.array(region.size) / 2
    low, high = middle - half, middle + half - size
    along: list[Array] = []
    clear: list[NDArray[np.bool_]] = []
    for i in range(2):
        pitch, gap = size[i] + way.gaps[i], way.gaps[i]
        lattice = np.arange(low[i], high[i] + SAME, pitch)
        values = np.concatenate([lattice, others[:, i + 2] + gap, others[:, i] - pitch])
        values = values[(values > low[i] - SAME) & (values < high[i] + SAME)]
        values = np.unique(np.round(values / SAME)) * SAME
        along.append(values)
        room = np.maximum(others[:, i] - (values[:, None] + size[i]), values[:, None] - others[:, i + 2])
        clear.append(room > gap - 2 * SAME)
    free = (clear[0][:, None, :] | clear[1][None, :, :]).all(axis=2)
    x, y = np.nonzero(free)
    return np.stack([along[0][x], along[1][y]], axis=1)


def _order(workspace: Workspace, region: Region, way: Rows, centers: Array) -> NDArray[np.intp]:
    """The order in which places (n, 2) are filled: within the arm's best reach first, of those the far rows first."""
    spec = workspace.world.robot.spec
    base, (near, far) = np.array(spec.T_world_base.xyz[:2]), spec.reach
    distance = np.linalg.norm(centers - base, axis=1)
    beyond = np.maximum(near - distance, 0.0) + np.maximum(distance - far, 0.0)
    away = np.sign(np.array(region.center) - base) * centers
    return np.lexsort((-away[:, 1 - way.axis], -away[:, way.axis], beyond))


def _turns(workspace: Workspace, obj: str, R: Array, grasp: Grasp | None, axis: int) -> list[Array]:
    """Two orientations (3, 3), half a turn apart, parallel to the region and with the fingers closing along an axis."""
    angle = _aligning(workspace, obj, R)
    quarters = [turned(R, angle + k * np.pi / 2) for k in range(4)]
    if grasp is None:
        spans = [upper - lower for lower, upper in (_bounds(workspace.points(obj) @ turn.T) for turn in quarters)]
        across = [-float(span[axis]) for span in spans]
    else:
        closing = grasp.T_object_tool.matrix[:3, :3] @ np.array(workspace.world.robot.spec.gripper.axis)
        across = [abs(float((turn @ closing)[axis])) for turn in quarters]
    first = 0 if across[0] > across[1] - SAME else 1
    return [quarters[first], quarters[first + 2]]


def _aligning(workspace: Workspace, obj: str, R: Array) -> float:
    """The least turn about the vertical after which the rectangle round an object turned by R is smallest [rad]."""

    def found() -> float:
        points = (workspace.points(obj) @ R.T)[:, :2]
        corners = outline(points)
        edges = np.roll(corners, -1, axis=0) - corners
        angles = -np.arctan2(edges[:, 1], edges[:, 0])
        angles = (angles + np.pi / 4) % (np.pi / 2) - np.pi / 4
        spans = [np.ptp(points @ turned(np.eye(3), float(angle))[:2, :2].T, axis=0) for angle in angles]
        areas = [float(np.prod(span)) for span in spans]
        least = min(areas) * (1.0 + SAME)
        return min((float(angle) for angle, area in zip(angles, areas, strict=True) if area < least), key=abs)

    return workspace.cache.value(("aligning", obj, R.tobytes()), found)


def _sides(workspace: Workspace, obj: str) -> Array:
    """Sides of the smallest rectangle round an object as it stands at the start, the narrow one first, (2,) [m]."""
    R = workspace.start[obj].pose.matrix[:3, :3]
    lower, upper = _bounds(workspace.points(obj) @ turned(R, _aligning(workspace, obj, R)).T)
    sides: Array = np.sort((upper - lower)[:2])
    return sides


def _bounds(points: Array) -> tuple[Array, Array]:
    return points.min(axis=0), points.max(axis=0)
