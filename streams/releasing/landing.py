"""Where something lands that is let go on one edge: simulated, since edges skid, rock and turn as no formula says."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.monitor import angle_between
from tamp.execution.settling.settle import let_fall
from tamp.streams.affordances.neighbours import carriers
from tamp.streams.hand.candidates import hangs_over
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

Fall = tuple[Pose, ...]

SAME_FACE = 0.08  # angle between what is up where it lands, and where it shall lie, on the same face [rad]
UPRIGHT = 0.04  # vertical share of the axis that it turns about on the whole, at most ...
TWIST = 0.45  # ... and so much more where it falls over a corner, as far as its centre of mass is beside that
CARRYING = 0.003  # what is so little above its lowest point is part of its edge [m]
FARTHEST = 0.03  # that is aimed beside the placement: what goes farther aside lands nobody knows where [m]
SKIDS = 0.004  # how much farther aside than friction or ice explain the centre of mass may come [m] ...
CORNER = 0.018  # ... and so much more over a corner, but no more than it is beside that [m]
SHOTS = 5  # falls onto other objects that are simulated until one lands where it was aimed at
NEAR = 0.005  # so near to the placement is where it was aimed at [m]
BESIDE = 0.003  # let go so far beside what lands as it shall on other objects [m] ...
SWAYED = 0.02  # ... or, on the table, turned so far [rad] ...
SPREAD, TURNED = 0.02, 0.15  # ... it still lands so near to there [m], turned by no more [rad]
PUSHED = 0.003  # what it falls on stays where it is, but for this [m]


def aimed(workspace: Workspace, obj: str, placement: Placement, fall: Fall) -> Fall | None:
    """A fall over an edge, shifted so that the object comes to rest at its placement; None where it lands otherwise.

    Where it lands beside, it is let go as far to the other side. On a table every place is like the others, and that
    serves; on other objects it is seen where it lands then, and aimed anew a few times, and how sure that is.

    Args:
        workspace: where the object is, and which simulator tells how things come to rest.
        obj: the object.
        placement: where it shall lie.
        fall: its poses (world frame) as it turns over the edge, the tilted one first, the placement's last.
    """
    below = {name: place.pose for name, place in carriers(workspace, obj, placement).items()}

    def found() -> Fall | None:
        shot = _shot_in(workspace, obj, placement, below, fall)
        if shot is None or not _explained(workspace, obj, fall, shot):
            return None
        return (
            shot if whole_on_table(workspace, obj, placement) or _sure(workspace, obj, below, shot, _shifted) else None
        )

    return workspace.cache.value(("aimed", obj, placement, fall[0], *below.items()), found)


def _shot_in(
    workspace: Workspace, obj: str, placement: Placement, below: Mapping[str, Pose], fall: Fall
) -> Fall | None:
    """The fall, let go as far beside as it takes to land at the placement; None where that is too far."""
    center, shifted = workspace.world.geometries[obj].center_of_mass, fall
    for _ in range(SHOTS):
        end = _landed(workspace, obj, below, shifted[0])
        if end is None or not _same_face(end, placement.pose):
            return None
        if shifted is not fall and _is_at(end, placement.pose):
            return shifted
        nearer = _against(shifted, end)
        if nearer is None or whole_on_table(workspace, obj, placement):
            return nearer
        if shifted is not fall and float(np.linalg.norm(_aside(fall[0].matrix, nearer[0].matrix, center))) > FARTHEST:
            return None  # in all, however many shots it takes
        shifted = nearer
    return None


def whole_on_table(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether an object lies on the table and not over its edge: every such place is like the others."""
    return placement.on == (TABLE,) and not hangs_over(workspace, obj, placement)


def sure_on_table(workspace: Workspace, obj: str, fall: Fall) -> bool:
    """Whether an object lands near the same pose on the table if it is let go turned a little about a level axis."""
    return workspace.cache.value(("sure", obj, fall[0]), lambda: _sure(workspace, obj, {}, fall, _turned))


def _sure(
    workspace: Workspace,
    obj: str,
    below: Mapping[str, Pose],
    shot: Fall,
    disturbed: Callable[[Pose, float, float], Pose],
) -> bool:
    """Whether an object lands near the same pose if it is let go a little otherwise: it hardly ever is just so."""
    for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        end = _landed(workspace, obj, below, disturbed(shot[0], x, y))
        if end is None or math.dist(end.xyz, shot[-1].xyz) > SPREAD or angle_between(end, shot[-1]) > TURNED:
            return False
    return True


def _turned(pose: Pose, x: float, y: float) -> Pose:
    """A pose turned by SWAYED about a level axis."""
    T = pose.matrix.copy()
    T[:3, :3] = rotation(np.array([x, y, 0.0]), SWAYED) @ T[:3, :3]
    return Pose.from_matrix(T)


def _shifted(pose: Pose, x: float, y: float) -> Pose:
    """A pose shifted by BESIDE in a level direction."""
    return Pose((pose.xyz[0] + BESIDE * x, pose.xyz[1] + BESIDE * y, pose.xyz[2]), pose.quat)


def _landed(workspace: Workspace, obj: str, below: Mapping[str, Pose], let_go: Pose) -> Pose | None:
    """Where an object comes to rest that is let go at a pose; None where it does not, or pushes what is below it."""
    task = workspace.task
    bodies = [thing for thing in task.objects if thing.name == obj or thing.name in below]
    poses = let_fall(bodies, {**below, obj: let_go}, table=task.table, simulator=workspace.settling)
    if poses is None or any(np.linalg.norm(np.subtract(poses[n].xyz, below[n].xyz)) > PUSHED for n in below):
        return None
    return poses[obj]


def _same_face(one: Pose, other: Pose) -> bool:
    return float(one.matrix[2, :3] @ other.matrix[2, :3]) > math.cos(SAME_FACE)


def _is_at(one: Pose, other: Pose) -> bool:
    return _same_face(one, other) and bool(np.linalg.norm(np.subtract(one.xyz, other.xyz)) < NEAR)


def _against(fall: Fall, end: Pose) -> Fall | None:
    """The fall, let go as far beside as it lands on the other side, and turned as far; None where that is too far."""
    goal, landed = fall[-1].matrix, end.matrix
    R = goal[:3, :3] @ landed[:3, :3].T
    yaw = float(np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]))
    aside = goal[:2, 3] - landed[:2, 3]
    if float(np.linalg.norm(aside)) > FARTHEST:
        return None
    shares = np.linspace(1.0, 0.0, len(fall))
    return tuple(_beside(pose, goal[:3, 3], s * yaw, s * aside) for pose, s in zip(fall, shares, strict=True))


def _beside(pose: Pose, center: Array, yaw: float, aside: Array) -> Pose:
    """A pose, turned about the vertical through a point (3,) by an angle [rad] and shifted aside (2,) [m]."""
    turn, T = rotation(np.array([0.0, 0.0, 1.0]), yaw), pose.matrix.copy()
    T[:3, 3] = turn @ (T[:3, 3] - center) + center
    T[:3, :3] = turn @ T[:3, :3]
    T[:2, 3] += aside
    return Pose.from_matrix(T)


def _explained(workspace: Workspace, obj: str, rolled: Fall, fall: Fall) -> bool:
    """Whether an object turns about a level axis, and moves as friction or ice have it, or between the two.

    Held by friction it moves as it rolls over its edge; on ice its centre of mass falls straight down.
    """
    before, after = fall[0].matrix, fall[-1].matrix
    R = after[:3, :3] @ before[:3, :3].T
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    axis /= float(np.linalg.norm(axis))
    beside, lever = _over_corner(workspace, obj, before, axis)
    if abs(axis[2]) > UPRIGHT + TWIST * beside / lever:
        return False
    center = workspace.world.geometries[obj].center_of_mass
    goes, held = (_aside(poses[0].matrix, poses[-1].matrix, center) for poses in (fall, rolled))
    share = np.clip(goes @ held / max(float(held @ held), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(goes - share * held)) < SKIDS + min(beside, CORNER)


def _over_corner(workspace: Workspace, obj: str, T: Array, axis: Array) -> tuple[float, float]:
    """How far the centre of mass is beside the ends of the edge along an axis (3,), and from all of it [m]."""
    geometry = workspace.world.geometries[obj]
    edge = _lowest((geometry.hull.vertices - geometry.center_of_mass) @ T[:3, :3].T, geometry.hull.faces)[:, :2]
    along = edge @ axis[:2]
    beside = max(float(along.min()), float(-along.max()), 0.0)
    return beside, max(float(np.linalg.norm(edge, axis=1).min()), 1e-9)


def _lowest(vertices: Array, faces: NDArray[np.int64]) -> Array:
    """Corners of the part of a hull that is lowest, up to CARRYING, shape (m, 3) [m].

    Args:
        vertices: shape (n, 3) [m].
        faces: triangles of indices, shape (k, 3).
    """
    height = vertices[:, 2] - vertices[:, 2].min() - CARRYING
    ends = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    low, high = ends[(height[ends[:, 0]] < 0.0) & (height[ends[:, 1]] > 0.0)].T
    share = (height[low] / (height[low] - height[high]))[:, None]
    return np.vstack([vertices[height <= 0.0], vertices[low] + share * (vertices[high] - vertices[low])])


def _aside(before: Array, after: Array, center: Array) -> Array:
    """How far aside a body's point (3,) gets between two poses, shape (2,) [m]."""
    way: Array = (after[:3, :3] @ center + after[:3, 3] - before[:3, :3] @ center - before[:3, 3])[:2]
    return way
