"""Grasps without a model: opposite oriented points of the fused cloud, with room for the hand among what was measured.

After ten Pas, Gualtieri, Saenko and Platt, "Grasp pose detection in point clouds" (IJRR 2017), without learning.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.volume import Volume
from tamp.streams.context import Context
from tamp.streams.values import Grasp
from tamp.task.pose import Pose
from tamp.task.robot import RobotSpec
from tamp.world.robot.model import robot_model

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLANT = np.cos(np.radians(18))
"""Least cosine between the line of a pair and either normal."""

THINNEST = 0.006
"""Pairs nearer than this [m] are noise of one surface."""

SEEDS, PAIRS = 500, 300
APPROACHES = 12
DEPTHS = (0.004, 0.010, 0.018)
"""How far the tool's origin is beyond the middle of a pair, towards where it approaches to [m]."""

BESIDE = 0.008
"""Room on each side before the fingers close [m]."""

TOUCH = 0.004
"""A measured point this near to the hand is hit [m]."""

MOST = 120


@dataclass(frozen=True, eq=False)
class Pinch:
    """A grasp in the world frame: the tool's pose (4, 4), the width between the pads [m], and the room beside [m]."""

    T_world_tool: Array
    width: float
    clearance: float


def pinches(scene: Volume, own: NDArray[np.int64], robot: RobotSpec, rng: np.random.Generator) -> list[Pinch]:
    """Grasps of some points of a cloud, the most upright and central first.

    Args:
        scene: what was measured; the hand must not touch any of it but the points between its pads.
        own: indices of the points to be grasped.
        robot: its hand; the gripper's axis is where the pads close.
        rng: source of every random choice.
    """
    cloud = scene.cloud.at(own)
    first, second = _pairs(cloud, robot.gripper.stroke - 0.004, rng)
    if not len(first):
        return []
    middle = cloud.points.mean(axis=0)
    found: list[tuple[float, Array, Array, float]] = []
    for a, b in zip(first, second, strict=True):
        line = cloud.points[b] - cloud.points[a]
        width = float(np.linalg.norm(line))
        center = (cloud.points[a] + cloud.points[b]) / 2
        off = float(np.linalg.norm((center - middle)[:2]))
        frames = _frames(line / width, np.array(robot.gripper.axis))
        found += [(1 + float(R[2, 2]) + 8 * off, R, center, width) for R in frames]
    found.sort(key=lambda item: item[0])
    return _clear(scene, found, robot)


def _clear(scene: Volume, found: list[tuple[float, Array, Array, float]], robot: RobotSpec) -> list[Pinch]:
    """The first grasps in which the hand touches nothing; each as deep as there is room for."""
    kept = []
    for _, R, center, width in found:
        clearance = min(BESIDE, (robot.gripper.stroke - width) / 2)
        hand, linkage = hand_points(robot, round(width + 2 * clearance, 3)), robot_model(robot).linkage
        for depth in DEPTHS[::-1]:
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = R, center + (depth - float(linkage.depth(width))) * R[:, 2]
            if not _hits(scene, hand @ R.T + T[:3, 3]):
                kept.append(Pinch(T, width, clearance))
                break
        if len(kept) == MOST:
            break
    return kept


def _hits(scene: Volume, points: Array) -> bool:
    """Whether points of the hand are under the table or at something that was measured."""
    if (points[:, 2] < TOUCH).any():
        return True
    nearest, _ = scene.look_up(points)
    near = nearest >= 0
    gap = np.linalg.norm(scene.cloud.points[nearest[near]] - points[near], axis=1)
    return bool((gap < TOUCH).any())


def _pairs(cloud: Cloud, widest: float, rng: np.random.Generator) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of points whose normals look away from each other along the line between them."""
    if len(cloud.points) < 10:
        none = np.empty(0, dtype=np.int64)
        return none, none
    tree = cKDTree(cloud.points)
    seeds = rng.permutation(len(cloud.points))[:SEEDS]
    first, second = [], []
    for a in seeds.tolist():
        near = np.array(tree.query_ball_point(cloud.points[a], widest), dtype=np.int64)
        line = cloud.points[near] - cloud.points[a]
        width = np.linalg.norm(line, axis=1)
        unit = line / np.maximum(width, 1e-9)[:, None]
        opposite = (unit @ -cloud.normals[a] > SLANT) & (np.einsum("ij,ij->i", unit, cloud.normals[near]) > SLANT)
        opposite &= width > THINNEST
        if opposite.any():
            first.append(a)
            second.append(int(near[opposite][int(np.argmax((unit @ -cloud.normals[a])[opposite]))]))
        if len(first) == PAIRS:
            break
    return np.array(first, dtype=np.int64), np.array(second, dtype=np.int64)


def _frames(line: Array, axis: Array) -> Iterator[Array]:
    """Tool orientations whose closing axis lies along a line and whose z looks down, the steepest first."""
    other = np.array([1.0, 0.0, 0.0]) if abs(line[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    u = np.cross(line, other)
    u /= np.linalg.norm(u)
    v = np.cross(line, u)
    ways = [np.cos(t) * u + np.sin(t) * v for t in np.arange(APPROACHES) * 2 * np.pi / APPROACHES]
    down = np.array([0.0, 0.0, -1.0]) - line * -line[2]
    if np.linalg.norm(down) > 0.1:
        ways.insert(0, down / np.linalg.norm(down))
    third = np.cross(axis, [0.0, 0.0, 1.0])
    own = np.column_stack([third, axis, [0.0, 0.0, 1.0]])
    for z in sorted(ways, key=lambda way: float(way[2])):
        if z[2] < -0.3:
            yield np.column_stack([np.cross(line, z), line, z]) @ own.T


@lru_cache(maxsize=128)
def hand_points(robot: RobotSpec, opening: float) -> Array:
    """Points on the hulls of hand and fingers with the pads `opening` apart [m], in the tool frame, shape (n, 3)."""
    model = robot_model(robot)
    joints = model.joint_poses(np.array([robot.home]), opening)[0]
    T_tool_world = np.linalg.inv(joints[model.tool_joint] @ model.T_joint_tool)
    rng = np.random.default_rng(0)
    found = []
    for index in model.hand:
        body = model.bodies[index]
        corners = body.hull.vertices[body.hull.faces]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        chosen = rng.choice(len(areas), size=350, p=areas / areas.sum())
        weights = rng.dirichlet((1.0, 1.0, 1.0), size=350)
        T = T_tool_world @ joints[body.joint]
        found.append(np.einsum("nij,ni->nj", corners[chosen], weights) @ T[:3, :3].T + T[:3, 3])
    points = np.concatenate(found)
    points.setflags(write=False)
    return points


@dataclass(frozen=True, eq=False)
class CloudGrasps:
    """A sampler for `sample-grasp` that looks at a fused cloud where others look at meshes.

    Attributes:
        scene: what was measured, see `see`.
        margin: how far around an object's box measured points count as its own [m].
    """

    scene: Volume
    margin: float = 0.006

    def __call__(self, context: Context, obj: str) -> Iterator[Grasp]:
        """Yield grasps of obj where it stands, best first."""
        workspace = context.scene
        pose: Pose = workspace.start[obj].pose
        lower, upper = workspace.bounds(obj, pose)
        points = self.scene.cloud.points
        own = np.flatnonzero(((points > lower - self.margin) & (points < upper + self.margin)).all(axis=1))
        found = pinches(self.scene, own, workspace.world.robot.spec, context.rng)
        if not found:
            context.fail(f"no two opposite surfaces of {obj} were seen with room for the hand", proven=False)
        T_object_world = pose.inverse().matrix
        for pinch in found:
            yield Grasp(Pose.from_matrix(T_object_world @ pinch.T_world_tool), pinch.width, pinch.clearance)
