"""Tilted poses from which an object, one edge on its support and let go, rolls over it and falls flat."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.streams.affordances.stable_poses import base, outline
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.transforms import rotation, turned_about

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry.object_geometry import Geometry

    Array = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
ROLL = np.radians(2.5)  # between two poses
TOUCHING = 5e-4  # what is so near to the plane touches it [m]


def rolls(vertices: Array, T: Array, outward: Array) -> Iterator[tuple[Array, Array]]:
    """Yield where a body is as it rolls on, without end, and how far out it touches the plane there.

    It turns by ROLL at a time, about the outermost of its points that touch.

    Args:
        vertices: of its hull in its own frame, shape (n, 3) [m].
        T: where it rests on the plane, T_world_body, shape (4, 4).
        outward: level unit vector in which it rolls, shape (2,).

    Yields:
        T_world_body, shape (4, 4), and the touching points along `outward`, shape (m,) [m].
    """
    ground = float((vertices @ T[2, :3] + T[2, 3]).min())
    turn = rotation(np.array([-outward[1], outward[0], 0.0]), ROLL)
    while True:
        world = vertices @ T[:3, :3].T + T[:3, 3]
        low = world[world[:, 2] < ground + TOUCHING]
        T = turned_about(low[np.argmax(low[:, :2] @ outward)], turn, T)
        world = vertices @ T[:3, :3].T + T[:3, 3]
        T[2, 3] += ground - world[:, 2].min()
        yield T, world[world[:, 2] < world[:, 2].min() + TOUCHING, :2] @ outward


LEAST, MOST = np.radians(10.0), np.radians(60.0)  # tilts worth trying
STEP = np.radians(10.0)  # between two tilts
LEVER = 0.005  # the centre of mass stays at least this far on the falling side of the edge [m]
CARRYING = 0.004  # what of a round edge is so near to the plane may carry as well [m]
BEYOND = 0.002  # the centre of mass stays at least this far on the falling side of that [m]
TURNED_OVER = 0.5  # cosine of the angle between an object's upward direction now and then
UPSIDE_DOWN = -0.5  # the same where hardly any hand gets above the object both now and as it is let go
APART = np.radians(20.0)  # directions nearer to each other than this are one
WAYS = 36  # level ones in which what has fallen may tip on
STRUCK = 0.0025  # what is so near to the plane strikes it as well, where an edge is round [m]
TIPS = 0.195  # share of what it takes to tip on from which on it may: the checker grants hardly more
ROCKING = np.radians(np.arange(1.0, 91.0))  # how far a body has turned over its edge when its height is asked
STRAY = 0.0155  # share of a fall's energy that rocks what comes down, to whatever side: no edge strikes evenly
FLAT = 0.01  # a base narrower than this carries nothing that falls on it [m]


@dataclass(frozen=True)
class Tilt:
    """A tilted pose and the way down from it.

    Attributes:
        angle: of the tilt [rad].
        fall: poses that the object passes, the tilted one first, the placement's last.
    """

    angle: float
    fall: tuple[Pose, ...]


def tilts(workspace: Workspace, obj: str, placement: Placement) -> tuple[Tilt, ...]:
    """All tilts worth trying above a placement, the least first; none where the object does not lie on a flat base.

    From none of them it tips on over its far edge as it comes down on the table; what it lies in else may keep it.
    """

    def found() -> tuple[Tilt, ...]:
        geometry = workspace.world.geometries[obj]
        every = _tilts(geometry.hull.vertices, geometry.center_of_mass, placement.pose.matrix)
        free = placement.on == (TABLE,)
        stays = (tilt for tilt in every if not (free and tips_on(geometry, tilt.fall[0], tilt.fall[-1])))
        return tuple(sorted(stays, key=lambda tilt: tilt.angle))

    return workspace.cache.value(("tilts", obj, placement), found)


def layable(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether laying an object down at a placement is worth a thought: a hand that puts it down may be in its own way.

    That is so where the object, as it lies, is wider than the hand opens, and where it has to be turned over: what
    grasped it from above would then be below it.
    """
    return too_wide(workspace, obj, placement) or _turned(workspace, obj, placement) < TURNED_OVER


def upside_down(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether an object has to be turned over for a placement, which takes two grasps but for rare ones."""
    return _turned(workspace, obj, placement) < UPSIDE_DOWN


def _turned(workspace: Workspace, obj: str, placement: Placement) -> float:
    """Cosine of the angle between what is up of an object now, and at a placement."""
    return float(workspace.start[obj].pose.matrix[2, :3] @ placement.pose.matrix[2, :3])


def too_wide(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether an object is wider than the hand opens, as it lies, from every side."""
    points = workspace.world.geometries[obj].hull.vertices @ placement.pose.matrix[:2, :3].T
    angles = np.linspace(0.0, np.pi, 36, endpoint=False)
    along = points @ np.stack([np.cos(angles), np.sin(angles)])
    width: float = (along.max(axis=0) - along.min(axis=0)).min()
    return width > workspace.world.robot.spec.gripper.stroke


def never_too_wide(workspace: Workspace, obj: str) -> bool:
    """Whether an object is narrow enough for the hand from some side however it lies, as the box around it says.

    Seen from anywhere, a box is no wider than the diagonal of its smallest face in the direction that runs along that
    face.
    """
    vertices = workspace.world.geometries[obj].hull.vertices
    smallest = np.sort(vertices.max(axis=0) - vertices.min(axis=0))[:2]
    return float(np.linalg.norm(smallest)) <= workspace.world.robot.spec.gripper.stroke


def _tilts(vertices: Array, center: Array, T_goal: Array) -> Iterator[Tilt]:
    """The tilts of a body with these hull vertices (n, 3) and centre of mass (3,), both in its own frame."""
    world = vertices @ T_goal[:3, :3].T + T_goal[:3, 3]
    for outward in base_normals(base(world)):
        rolled = [T_goal]
        for T in _rolling(vertices, center, T_goal, outward):
            rolled.append(T)
            angle = ROLL * (len(rolled) - 1)
            on_step = angle > LEAST - 1e-9 and abs(angle / STEP - round(angle / STEP)) < 1e-6
            if on_step and _falls_back(vertices, center, T, outward):
                yield Tilt(angle, tuple(Pose.from_matrix(T) for T in reversed(rolled)))


def _rolling(vertices: Array, center: Array, T: Array, outward: Array) -> Iterator[Array]:
    """Poses of a body that is rolled up over its edge towards `outward` (2,), as far as it would fall back."""
    for rolled, touching in islice(rolls(vertices, T, outward), round(MOST / ROLL)):
        if (rolled[:3, :3] @ center + rolled[:3, 3])[:2] @ outward > touching.min() - LEVER:
            return
        yield rolled


def _falls_back(vertices: Array, center: Array, T: Array, outward: Array) -> bool:
    """Whether a body rolled towards `outward` (2,) to T, shape (4, 4), falls back whatever of its edge carries it."""
    world = vertices @ T[:3, :3].T + T[:3, 3]
    carrying = world[world[:, 2] < world[:, 2].min() + CARRYING, :2]
    return float((T[:3, :3] @ center + T[:3, 3])[:2] @ outward) < float((carrying @ outward).min()) - BEYOND


def tips_on(geometry: Geometry, before: Pose, after: Pose) -> bool:
    """Whether a body that turns over from one pose to another, and comes down flat there, tips on over its far edge.

    Its angular momentum about that edge is kept, as where that strikes it is stopped and nowhere else; some of its
    energy goes any way, since no face strikes evenly: it rocks from one side onto the other.
    """
    R, center = after.matrix[:3, :3], after.matrix[:3, :3] @ geometry.center_of_mass + after.xyz
    fallen = center - before.matrix[:3, :3] @ geometry.center_of_mass - before.xyz
    turned = R @ before.matrix[:3, :3].T
    skew = np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]) / 2
    sine = float(np.linalg.norm(skew))
    axis, half = skew / sine, np.arctan2(sine, (np.trace(turned) - 1) / 2) / 2
    across = fallen - axis * (axis @ fallen)
    arm = (across + np.cross(across, axis) / np.tan(half)) / 2  # from the axis that it turns about
    inertia, world = R @ geometry.inertia @ R.T, geometry.hull.vertices @ R.T + after.xyz
    corners = world[world[:, 2] < world[:, 2].min() + STRUCK]
    return bool(_tips(inertia, axis, arm, -float(fallen[2]), world - center, corners - center))


@compiled
def _tips(inertia: Array, axis: Array, arm: Array, sunk: float, hull: Array, struck: Array) -> bool:
    """Whether a body that turned over an axis and sank tips on over any edge of the base that it comes down on.

    Args:
        inertia: about its centre of mass, for a mass of one kilogram, shape (3, 3) [m^2].
        axis: unit vector, shape (3,).
        arm: from the axis to the centre of mass, shape (3,) [m].
        sunk: how far the centre of mass did [m].
        hull: its corners from the centre of mass, shape (n, 3) [m].
        struck: those that strike the plane, likewise, shape (m, 3) [m].
    """
    for k in range(WAYS):
        angle = 2 * np.pi * k / WAYS
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        over = np.array([-way[1], way[0], 0.0])
        along = struck[:, 0] * way[0] + struck[:, 1] * way[1]
        edge, lever, opposite = struck[along.argmax()], -struck[along.argmax()], -struck[along.argmin()]
        kept = max(_kept(inertia, axis, arm, over, lever), STRAY * _kept(inertia, over, opposite, over, lever))
        if sunk * kept > 0.0 and sunk * kept > TIPS * _barrier(edge, hull, way):
            return True
    return False


@compiled
def _kept(inertia: Array, axis: Array, arm: Array, over: Array, lever: Array) -> float:
    """Share of its energy that a body keeps which turned about one axis, and is stopped so as to turn about another.

    Args:
        inertia: about its centre of mass, for a mass of one kilogram, shape (3, 3) [m^2].
        axis: unit vector, shape (3,).
        arm: from the axis to the centre of mass, shape (3,) [m].
        over: the other axis, likewise.
        lever: likewise.
    """
    speed = np.cross(axis, arm)
    momentum = _form(over, inertia, axis) + (over * np.cross(lever, speed)).sum()
    before = _form(axis, inertia, axis) + (arm * arm).sum() - (axis * arm).sum() ** 2
    after = _form(over, inertia, over) + (lever * lever).sum() - (over * lever).sum() ** 2
    return float(max(momentum, 0.0) ** 2 / (before * after))


@compiled
def _form(a: Array, matrix: Array, b: Array) -> float:
    """The form a . M b of vectors (3,) and a matrix (3, 3)."""
    found = 0.0
    for i in range(3):
        for j in range(3):
            found += a[i] * matrix[i, j] * b[j]
    return found


@compiled
def _barrier(edge: Array, hull: Array, way: Array) -> float:
    """How high a body's centre of mass is lifted before it tips for good over an edge of what it stands on [m].

    What comes down on the plane clearly before it is in balance on that edge, as the rim of a plate on a narrow foot,
    carries it from there on: it rolls on over its hull as long as that lifts it.

    Args:
        edge: from the centre of mass to the edge, shape (3,) [m].
        hull: from the centre of mass to the corners of the hull, shape (n, 3) [m].
        way: level unit vector in which it tips, shape (3,).
    """
    inside, height = max((edge * way).sum(), 0.0), -edge[2]
    radius = np.hypot(inside, height)
    clearly = np.arctan2(inside, height) - np.arcsin(min(BEYOND / radius, 1.0))
    along = hull[:, 0] * way[0] + hull[:, 1] * way[1]
    lowest = (np.sin(clearly) * along - np.cos(clearly) * hull[:, 2]).max()
    if clearly <= 0.0 or lowest < inside * np.sin(clearly) + height * np.cos(clearly) + TOUCHING:
        return float(radius - height)
    highest = lowest
    for angle in ROCKING:
        turned = clearly + angle
        lifted = (np.sin(turned) * along - np.cos(turned) * hull[:, 2]).max()
        if lifted <= highest:
            break
        highest = lifted
    return float(highest - height)


def base_normals(points: Array) -> list[Array]:
    """Outward normals (2,) of the edges of a base's outline, the longest edges first, similar ones left out."""
    corners = outline(points)
    if len(corners) < 3:
        return []
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(edges, axis=1)
    across = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / lengths[:, None]
    if np.ptp(corners @ across.T, axis=0).min() < FLAT:
        return []
    kept: list[Array] = []
    for index in np.argsort(-lengths, kind="stable"):
        if lengths[index] > 1e-4 and all(across[index] @ other < np.cos(APART) for other in kept):
            kept.append(across[index])
    return kept
