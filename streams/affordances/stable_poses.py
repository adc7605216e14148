"""Stable poses: what an object stands on, and whether its centre of mass is over it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry.object_geometry import Geometry

    Array = NDArray[np.float64]

TOUCHING = 0.002  # vertices this low above the lowest are part of the base [m]
LIKELY = 0.02  # a face that a thrown object comes to rest on less often than this is left out
SURE = 0.25  # one that it comes to rest on more often is steady: if it rocks there at all, then not far
BALANCE = 0.002  # the centre of mass lies at least this far inside the base [m]
STEADY = 0.08  # and this far for each metre above it: tipped by four degrees by opening fingers, it stands up again
ROCKED = np.radians(np.arange(5.0, 61.0, 5.0))  # how far a body that falls onto a face may rock on from there [rad]
HEADINGS = 36  # in which it may
UPHILL = 0.15  # it stays where its centre of mass would have to rise by this share of its height for that


def base(vertices: Array) -> Array:
    """Those of a standing body's vertices (n, 3) that are lowest, seen from above, shape (m, 2)."""
    low: Array = vertices[vertices[:, 2] < vertices[:, 2].min() + TOUCHING, :2]
    return low


def outline(points: Array) -> Array:
    """Corners (n, 2) of the convex hull of points (m, 2), counter-clockwise; fewer than three where they are in line.

    Andrew's monotone chain (Information Processing Letters 1979).
    """
    ordered = points[np.lexsort(points.T[::-1])]
    chains = (way[_chain(np.ascontiguousarray(way))] for way in (ordered, ordered[::-1]))
    return np.concatenate([chain[:-1] for chain in chains]).reshape(-1, 2)


@compiled
def _chain(ordered: Array) -> NDArray[np.int64]:
    """Indices of the corners that points (m, 2), ordered along x, have on their right, both ends included."""
    kept, count = np.empty(len(ordered), np.int64), 0
    for index in range(len(ordered)):
        x, y = ordered[index]
        while count > 1:
            ax, ay = ordered[kept[count - 2]]
            bx, by = ordered[kept[count - 1]]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                break
            count -= 1
        kept[count] = index
        count += 1
    return kept[:count]


def stands(geometry: Geometry, R: Array) -> bool:
    """Whether a body turned by R, shape (3, 3), stays as it is on a plane when a hand lets go of it there."""
    turned, center = geometry.hull.vertices @ R.T, R @ geometry.center_of_mass
    corners = outline(base(turned))
    if len(corners) < 3:
        return False
    return inside_by(corners, center[:2]) > max(BALANCE, STEADY * float(center[2] - turned[:, 2].min()))


def tips_at(geometry: Geometry, R: Array) -> float:
    """How far a body that stands on a plane, turned by R, shape (3, 3), is tilted before it tips over [rad].

    Negative where it tips over as it is.
    """
    turned, center = geometry.hull.vertices @ R.T, R @ geometry.center_of_mass
    corners = outline(base(turned))
    if len(corners) < 3:
        return 0.0
    return float(np.arctan2(inside_by(corners, center[:2]), center[2] - turned[:, 2].min()))


def inside_by(corners: Array, point: Array) -> float:
    """How far inside a convex polygon, corners (n, 2) counter-clockwise, a point (2,) is; negative outside [m]."""
    edges = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    return float(np.einsum("ij,ij->i", inward, point - corners).min())


def stays(geometry: Geometry, R: Array) -> bool:
    """Whether a body that falls onto a plane, turned by R, shape (3, 3), stays so and does not roll or tip over.

    What is round has a low ridge to the next of its many faces, and what stands on a narrow end to the next broad one.
    """
    from_center = (geometry.hull.vertices - geometry.center_of_mass) @ R.T
    headings = np.linspace(0.0, 2 * np.pi, HEADINGS, endpoint=False)
    level = np.stack([np.cos(headings), np.sin(headings), np.zeros(HEADINGS)])
    down = np.sin(ROCKED)[:, None, None] * level - np.cos(ROCKED)[:, None, None] * np.array([[0.0], [0.0], [1.0]])
    ridges = np.max(from_center @ down, axis=(0, 1))
    height = -from_center[:, 2].min()
    return bool(ridges.min() > (1.0 + UPHILL) * height)


LEVEL = 1e-4  # vertices of a base that are no farther apart in height are in one plane [m]
FORWARD = 1e-5  # what a body tips over lies at least so far ahead of where it turns [m]
FACETS = 60  # that it tips over at most
SUNK = 0.02  # how far what rests in a simulator is turned from that [rad]


def righted(geometry: Geometry, R: Array) -> Array:
    """The orientation (3, 3) in which a body comes to rest on a plane that is put down on it turned by R, (3, 3).

    As long as its centre of mass is not over what touches the plane it tips over the nearest edge of that. Where it
    does not turn by more than a simulator lets things sink in, that is R itself.
    """
    found = R
    for _ in range(FACETS):
        points = (geometry.hull.vertices - geometry.center_of_mass) @ found.T
        points[:, 2] -= points[:, 2].min()
        touching = points[points[:, 2] < LEVEL, :2]
        edge = _nearest_to_origin(outline(touching) if len(touching) > 1 else touching)
        distance = float(np.linalg.norm(edge))
        if distance < LEVEL:
            break
        ahead = -edge / distance  # from the edge to below the centre of mass
        forward = (points[:, :2] - edge) @ ahead
        beyond = (forward > FORWARD) & (points[:, 2] > LEVEL)
        angle = np.arctan2(points[beyond, 2], forward[beyond]).min(initial=np.pi)
        found = rotation(np.array([-ahead[1], ahead[0], 0.0]), float(angle)) @ found
    return found if found[2] @ R[2] < np.cos(SUNK) else R


def _nearest_to_origin(corners: Array) -> Array:
    """The point, (2,), of a convex polygon, corners (n, 2) counter-clockwise, or of a line, nearest to the origin."""
    if len(corners) > 2 and inside_by(corners, np.zeros(2)) >= 0.0:
        return np.zeros(2)
    ways = np.roll(corners, -1, axis=0) - corners
    lengths = np.maximum((ways * ways).sum(axis=1), 1e-18)
    shares = np.clip(-(corners * ways).sum(axis=1) / lengths, 0.0, 1.0)
    points = corners + shares[:, None] * ways
    nearest: Array = points[np.linalg.norm(points, axis=1).argmin()]
    return nearest


TIPPED = (0.05, 0.15, 0.35)  # by which a body is tipped to see whether it rolls on [rad]
RIDGE = 1e-4  # what its centre of mass must rise by on the way to stay [m]
LOWER = 3e-4  # what it is lower by in the end where it does not [m]


def rolls(geometry: Geometry, R: Array) -> bool:
    """Whether a body on a plane, turned by R, (3, 3), rolls on over ridges that are next to nothing."""
    return bool((_risen(geometry, R) < RIDGE).all(axis=0).any())


def rolls_down(geometry: Geometry, R: Array) -> bool:
    """Whether a body on a plane, turned by R, (3, 3), rolls on so and comes down."""
    risen = _risen(geometry, R)
    return bool(((risen < RIDGE).all(axis=0) & (risen[-1] < -LOWER)).any())


def tipped_on(geometry: Geometry, R: Array) -> Array | None:
    """How a body that only balances on a plane, turned by R, (3, 3), is turned as it begins to come down; else None."""
    if not rolls_down(geometry, R):
        return None
    risen = _risen(geometry, R)
    falls = (risen < RIDGE).all(axis=0)
    heading = 2 * np.pi * int(np.where(falls, risen[-1], np.inf).argmin()) / HEADINGS
    return rotation(np.array([-np.sin(heading), np.cos(heading), 0.0]), TIPPED[0]) @ R


def _risen(geometry: Geometry, R: Array) -> Array:
    """How high a body's centre of mass has risen as it is tipped by `TIPPED` in each heading, (3, headings) [m]."""
    from_center = (geometry.hull.vertices - geometry.center_of_mass) @ R.T
    headings = np.linspace(0.0, 2 * np.pi, HEADINGS, endpoint=False)
    level = np.stack([np.cos(headings), np.sin(headings), np.zeros(HEADINGS)])
    tipped = np.array(TIPPED)[:, None, None]
    down = np.sin(tipped) * level - np.cos(tipped) * np.array([[0.0], [0.0], [1.0]])
    return np.asarray(np.max(from_center @ down, axis=1) + from_center[:, 2].min())


def resting(workspace: Workspace, obj: str) -> list[Array]:
    """The orientations (3, 3) in which an object stands steadily on a plane, one for each of its faces."""
    from tamp.world.geometry.object_geometry import stable_poses

    geometry = workspace.world.geometries[obj]
    # A ball has many faces, none of them likely: any will do.
    return workspace.cache.value(
        ("resting", obj), lambda: steady_faces(geometry) or [pose.R for pose in stable_poses(geometry)[:1]]
    )


def steady_faces(geometry: Geometry) -> list[Array]:
    """The orientations (3, 3) in which a body lies steadily on a plane, the likeliest first; none for a ball."""
    from tamp.world.geometry.object_geometry import stable_poses

    poses = [pose for pose in stable_poses(geometry) if pose.probability > LIKELY]
    steady = [pose.R for pose in poses if pose.probability > SURE or stands(geometry, pose.R)]
    return [R for R in steady if not rolls_down(geometry, R)] or steady


def amid(workspace: Workspace, obj: str, R: Array) -> Placement:
    """An object in the orientation R, shape (3, 3), in the middle of the table."""
    T = np.eye(4)
    T[:3, :3] = R
    T[:2, 3] = workspace.task.table.center
    T[2, 3] = -float((workspace.points(obj) @ R[2]).min())
    return Placement(Pose.from_matrix(T), (TABLE,))


def turned(R: Array, angle: float) -> Array:
    """An orientation, shape (3, 3), turned about the vertical by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    found: Array = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ R
    return found


DIGITS = 9  # to which the orientations and heights of two placements agree that differ in nothing else


def midtable(workspace: Workspace, placement: Placement) -> Placement:
    """A placement on the table, shifted to its middle and turned about the vertical; the same one for all that differ.

    Args:
        workspace: where the table is.
        placement: of something that rests on the table.
    """
    pose = placement.pose.matrix
    T = np.eye(4)
    T[:3, :3] = _upward(np.round(pose[2, :3], DIGITS))
    T[:3, 3] = *workspace.task.table.center, round(float(pose[2, 3]), DIGITS)
    return Placement(Pose.from_matrix(T), placement.on)


def moved(fall: tuple[Pose, ...], placement: Placement) -> tuple[Pose, ...]:
    """Poses of an object that end in the middle of the table, moved so that they end at a placement like that."""
    T = placement.pose @ fall[-1].inverse()
    return (*(T @ pose for pose in fall[:-1]), placement.pose)


def _upward(up: NDArray[np.float64]) -> NDArray[np.float64]:
    """The orientation, shape (3, 3), chosen for all in which this axis of an object's own frame (3,) points up."""
    up = up / np.linalg.norm(up)
    ahead = np.eye(3)[np.argmin(np.abs(up))]
    ahead = ahead - (ahead @ up) * up
    ahead = ahead / np.linalg.norm(ahead)
    return np.stack([ahead, np.cross(up, ahead), up])
