"""Next best views: from where a camera on the arm most likely sees what is sought.

Volumetric information gain as in Connolly, "The determination of next best views" (ICRA 1985): cells that no camera
has seen, weighted by the chance that what is sought is there, and counted where a view would see them past what was
measured and past the arm itself. Views from above look into boxes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Camera, Frame, Intrinsics, looking_at
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.robot import camera_pose, link_pose
from tamp.perception.rendering.scene import robot_body
from tamp.task import Table
from tamp.world.collision.checker import CollisionChecker
from tamp.world.kinematics.inverse import inverse
from tamp.world.scene import Scene
from tamp.world.world import World

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from tamp.task import Pose

    Array = NDArray[np.float64]

CELL = 0.012
"""Edge of the cells that are sought through [m]."""

HIGH = 0.20
"""So high over the table objects are sought [m]."""

GAP = 0.010
"""A cell is seen where a camera measures at least as far as it, less this [m]; one nearer to a surface is its own."""

DISTANCES = (0.32, 0.45)
"""From the eye to what it looks at [m]."""

ELEVATIONS = tuple(math.radians(angle) for angle in (88.0, 68.0, 48.0))
AZIMUTHS = 10
TARGETS = 6
"""Places that views are aimed at."""

TRIED = 12
"""Views, the most telling first, that inverse kinematics is asked for."""

WORTH = 0.02
"""A view that shows new cells with fewer of the objects sought, as expected, is not worth its time."""

AROUND = 0.08
"""What is doubted is sought within this of where it is thought to be [m]..."""

ELSEWHERE = 0.3
"""... but for so much of the chance, which is elsewhere's."""

BACK = (0.05, 0.10, 0.15, 0.20)
"""So much farther back a camera looks from where its viewpoint is taken [m]."""

SMALL = 1 / 8
"""Share of a picture's size that decides what a view would show."""

MARGIN = 0.02
"""Least distance of the arm to what is known [m]."""


@dataclass(frozen=True, eq=False)
class Unseen:
    """Space over the table that no camera has seen into.

    Attributes:
        cells: their centres, shape (n, 3), world frame [m].
        surface: measured points, shape (m, 3).
    """

    cells: Array
    surface: Array


def unseen(frames: Sequence[Frame], table: Table) -> Unseen:
    """What no frame has seen into, and what they have measured."""
    middle, half = np.array([*table.center, 0.0]), np.array([table.size[0] / 2, table.size[1] / 2, 0.0])
    low, high = middle - half + (0.0, 0.0, CELL / 2), middle + half + (0.0, 0.0, HIGH)
    axes = [np.arange(a, b, CELL) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    known = np.zeros(grid[..., 0].size, dtype=bool)
    points = [np.empty((0, 3))]
    for frame in frames:
        known |= seen_into(frame.intrinsics, frame.T_world_camera, measured_depth(frame), grid.reshape(-1, 3), GAP)
        points.append(_points(frame))
    places = np.unique(np.round(np.concatenate(points) / (CELL / 2)).astype(np.int32), axis=0)
    surface = (CELL / 2) * places.astype(np.float64)
    return Unseen(grid[_sheltered(~known.reshape(grid.shape[:3]))], surface)


def _sheltered(hidden: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells (x, y, z) with at least three others unseen beside them: a lone one hides nothing."""
    padded = np.pad(hidden, 1).astype(np.int8)
    beside = [np.roll(padded, shift, axis) for axis in range(3) for shift in (1, -1)]
    return np.asarray(hidden & (np.sum(beside, axis=0)[1:-1, 1:-1, 1:-1] >= 3), dtype=np.bool_)


def measured_depth(frame: Frame) -> NDArray[np.float32]:
    """What was measured; behind the robot nothing is known."""
    return np.where(frame.robot, np.float32(0), frame.depth)


def _points(frame: Frame, step: int = 4) -> Array:
    depth = measured_depth(frame)[::step, ::step]
    local = frame.intrinsics.points_every(depth, step)[depth > 0].astype(np.float64)
    return local @ frame.T_world_camera[:3, :3].T + frame.T_world_camera[:3, 3]


def seen_into(
    k: Intrinsics, T_world_camera: Array, depth: NDArray[np.floating], cells: Array, gap: float
) -> NDArray[np.bool_]:
    """Cells that lie before what a picture shows."""
    local = (cells - T_world_camera[:3, 3]) @ T_world_camera[:3, :3]
    z = np.maximum(local[:, 2], 1e-6)
    u = np.floor(local[:, 0] / z * k.fx + k.cx).astype(int)
    v = np.floor(local[:, 1] / z * k.fy + k.cy).astype(int)
    inside = (local[:, 2] > 0.05) & (u >= 0) & (u < k.width) & (v >= 0) & (v < k.height)
    there = np.zeros(len(cells), dtype=bool)
    there[inside] = depth[v[inside], u[inside]] > z[inside] - gap
    return there


def next_views(
    hidden: Unseen,
    camera: Camera,
    world: World,
    poses: Mapping[str, Pose],
    rng: np.random.Generator,
    *,
    sought: Sequence[Array | None] = (None,),
) -> Iterator[tuple[float, ...]]:
    """Arm configurations from which the camera sees most of where objects may be, one after the other.

    Each is chosen given that those before it have been taken; it ends where a further one would show nothing new.

    Args:
        hidden: what has not been seen.
        camera: a camera on the arm.
        world: the planner's picture of robot, table and objects.
        poses: object -> where it is thought to be (world frame).
        rng: source of every random choice.
        sought: for each object where it is thought to be, shape (3,) [m]; None where nobody knows.
    """
    cells, weights = hidden.cells, _chances(hidden.cells, sought)
    checker = world.checker(
        Scene({name: pose.matrix for name, pose in poses.items()}, opening=world.robot.spec.gripper.stroke),
        margin=MARGIN,
    )
    views = list(_views(cells, weights, rng))
    unobstructed = [_shown(camera, T, hidden) for T in views]

    def look(i: int) -> _Look | None:
        q = _reached(camera, world, checker, views[i], rng)
        return None if q is None else _look_from(camera, world, q, hidden)

    while (best := _most_telling(look, unobstructed, weights)) is not None:
        yield best.q
        weights[best.shown] = 0.0


@dataclass(frozen=True, eq=False)
class _Look:
    """A configuration to look from [rad], and which cells it would show, shape (n,)."""

    q: tuple[float, ...]
    shown: NDArray[np.bool_]


def _most_telling(
    look: Callable[[int], _Look | None], unobstructed: Sequence[NDArray[np.bool_]], weights: Array
) -> _Look | None:
    """The look that shows most, of the views that may: those that would show most without an arm are tried first."""
    bounds = np.array([weights[shown].sum() for shown in unobstructed])
    best, most = None, WORTH
    for i in np.argsort(-bounds, kind="stable")[:TRIED].tolist():
        if bounds[i] < most:
            break
        found = look(i)
        if found is not None and (worth := float(weights[found.shown].sum())) >= most:
            best, most = found, worth
    return best


def _look_from(camera: Camera, world: World, q: tuple[float, ...], hidden: Unseen) -> _Look:
    T = camera_pose(camera, world.robot.spec, q)
    with open_renderer("raycast")([robot_body(world.robot.spec, q)]) as renderer:
        depth = renderer.picture(camera.intrinsics.scaled(SMALL), T).depth
    return _Look(q, _shown(camera, T, hidden, np.where(depth > 0, depth, np.inf)))


def _chances(cells: Array, sought: Sequence[Array | None]) -> Array:
    """How many of the objects sought are to be expected in each cell, shape (n,)."""
    chances = np.zeros(len(cells))
    for place in sought:
        around = np.zeros(len(cells), dtype=bool)
        if place is not None:
            around = np.linalg.norm(cells - place, axis=1) < AROUND
        here = 1 - ELSEWHERE if around.any() else 0.0
        chances += (1 - here) / max(1, len(cells)) + here * around / max(1, around.sum())
    return chances


def farther_back(
    camera: Camera, world: World, poses: Mapping[str, Pose], q: tuple[float, ...], rng: np.random.Generator
) -> Iterator[tuple[float, ...]]:
    """Configurations from which the camera looks the same way from farther back; none where `q` is free.

    Args:
        camera: a camera on the arm.
        world: the planner's picture of robot, table and objects.
        poses: object -> where it is thought to be (world frame).
        q: a configuration to look from [rad].
        rng: source of every random choice.
    """
    scene = Scene({name: pose.matrix for name, pose in poses.items()}, opening=world.robot.spec.gripper.stroke)
    checker = world.checker(scene, margin=MARGIN)
    if checker.free(np.array(q)):
        return
    eye = camera_pose(camera, world.robot.spec, q)
    for back in BACK:
        T = eye.copy()
        T[:3, 3] -= back * eye[:3, 2]
        found = _reached(camera, world, checker, T, rng)
        if found is not None:
            yield found


def _views(cells: Array, weights: Array, rng: np.random.Generator) -> Iterator[Array]:
    """Camera poses (4, 4) around places where much is hidden."""
    if not len(cells):
        return
    targets: list[Array] = []
    left = weights.copy()
    while len(targets) < TARGETS and left.sum() > 0:
        middle = cells[rng.choice(len(cells), p=left / left.sum())]
        near = np.linalg.norm(cells - middle, axis=1) < 0.10
        targets.append(cells[near].mean(axis=0))
        left[near] = 0.0
    for target in targets:
        for elevation in ELEVATIONS:
            for azimuth in np.arange(AZIMUTHS) * 2 * math.pi / AZIMUTHS:
                flat = math.cos(elevation)
                way = np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])
                for distance in DISTANCES:
                    yield looking_at(target + distance * way, target)


def _shown(
    camera: Camera, T_world_camera: Array, hidden: Unseen, arm: NDArray[np.floating] | None = None
) -> NDArray[np.bool_]:
    """Cells that a view would show past what was measured, and past the arm, given its depth where it is in view."""
    k, surface = camera.intrinsics.scaled(SMALL), hidden.surface
    depth = np.full((k.height, k.width), np.inf)
    local = (surface - T_world_camera[:3, 3]) @ T_world_camera[:3, :3]
    local = local[local[:, 2] > 0.05]
    u = np.floor(local[:, 0] / local[:, 2] * k.fx + k.cx).astype(int)
    v = np.floor(local[:, 1] / local[:, 2] * k.fy + k.cy).astype(int)
    inside = (u >= 0) & (u < k.width) & (v >= 0) & (v < k.height)
    np.minimum.at(depth, (v[inside], u[inside]), local[inside, 2])
    near = depth.copy()  # points are sparser than pixels: each covers its neighbours
    for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (-1, -1), (1, -1), (-1, 1)):
        near = np.minimum(near, np.roll(depth, (dv, du), axis=(0, 1)))
    return seen_into(k, T_world_camera, near if arm is None else np.minimum(near, arm), hidden.cells, GAP)


def _reached(
    camera: Camera, world: World, checker: CollisionChecker, T_world_camera: Array, rng: np.random.Generator
) -> tuple[float, ...] | None:
    """A free configuration that puts the camera at a pose, turned about its axis as the arm likes."""
    robot = world.robot
    home = np.array(robot.home)
    T_link_tool = np.linalg.inv(link_pose(robot, camera.parent, home.tolist(), 0.0)) @ robot.forward(home)
    for turn in (0.0, math.pi, math.pi / 2, -math.pi / 2):
        c, s = math.cos(turn), math.sin(turn)
        roll = np.array([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
        T_world_link = T_world_camera @ roll @ np.linalg.inv(camera.T_parent_camera.matrix)
        found = inverse(robot, T_world_link @ T_link_tool, rng, near=home, count=2, checker=checker)
        q = next(found, None)
        if q is not None:
            return tuple(float(angle) for angle in q)
    return None
