"""Bodies as points and half-spaces, and the robot's links by Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pinocchio
from scipy.spatial import ConvexHull

from tamp.task import RobotSpec, Shape, load_robot
from tamp.task.mesh.parts import parts

SPACING = 0.01  # of the points on a surface [m]


@dataclass(frozen=True, eq=False)
class Body:
    """Convex pieces as half-spaces (m, 4), points on their surfaces, the box round them, and a sphere."""

    planes: tuple[np.ndarray, ...]
    points: np.ndarray
    box: np.ndarray
    center: np.ndarray
    radius: float

    @staticmethod
    def of(clouds: list[np.ndarray]) -> Body:
        planes, points = [], []
        for cloud in clouds:
            hull = ConvexHull(cloud)
            planes.append(hull.equations)
            for corners in cloud[hull.simplices]:
                n = int(np.ceil(max(np.linalg.norm(corners - corners[[1, 2, 0]], axis=1)) / SPACING))
                share = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
                points.append(share @ corners)
        every = np.vstack([*clouds, _thinned(np.vstack(points))])
        box = np.array([every.min(axis=0), every.max(axis=0)])
        center = box.mean(axis=0)
        return Body(tuple(planes), every, box, center, float(np.linalg.norm(every - center, axis=1).max()))


def _thinned(points: np.ndarray) -> np.ndarray:
    """One of the points in each cell of a grid, which is coarser on large bodies."""
    cell = max(SPACING, float(np.ptp(points, axis=0).max()) / 40)
    return points[np.unique(np.round(points / cell), axis=0, return_index=True)[1]]


def depth(a: Body, T_a: np.ndarray, b: Body, T_b: np.ndarray) -> float:
    """How deep the deepest surface point of one body lies inside the other [m]; negative where none does."""
    deepest = -np.inf
    for one, T_one, two, T_two in ((a, T_a, b, T_b), (b, T_b, a, T_a)):
        T = np.linalg.inv(T_two) @ T_one
        points = one.points @ T[:3, :3].T + T[:3, 3]
        points = points[((points > two.box[0]) & (points < two.box[1])).all(axis=1)]
        for planes in two.planes if len(points) else ():
            deepest = max(deepest, float((-(points @ planes[:, :3].T + planes[:, 3]).max(axis=1)).max()))
    return deepest


def within(body: Body, T: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which points of the world, shape (n, 3), are inside a body at T."""
    local = (points - T[:3, 3]) @ T[:3, :3]
    inside = [(local @ planes[:, :3].T + planes[:, 3] < 1e-6).all(axis=1) for planes in body.planes]
    return np.any(inside, axis=0)


def near(moving: Body, T: np.ndarray, still: Body, T_still: np.ndarray) -> list[int]:
    """At which of its poses, shape (n, 4, 4), a body may touch another."""
    T_still_moving = np.linalg.inv(T_still) @ T
    center = T_still_moving[:, :3, :3] @ moving.center + T_still_moving[:, :3, 3]
    beyond = np.maximum(still.box[0] - center, center - still.box[1]).clip(min=0.0)
    return np.flatnonzero(np.linalg.norm(beyond, axis=1) < moving.radius).tolist()


def meets(moving: Body, T: np.ndarray, still: Body, T_still: np.ndarray, limit: float) -> bool:
    """Whether a body is deeper than `limit` in another at any of its poses, shape (n, 4, 4)."""
    return any(depth(moving, T[k], still, T_still) > limit for k in near(moving, T, still, T_still))


@lru_cache(maxsize=256)
def body_of(shape: Shape) -> Body:
    return Body.of([part.vertices for part in parts(shape)])


@lru_cache(maxsize=1)
def robot() -> tuple[RobotSpec, pinocchio.Model, dict[str, Body]]:
    spec = load_robot("panda")
    model = pinocchio.buildModelFromUrdf(str(spec.urdf))
    geometry = pinocchio.buildGeomFromUrdf(
        model, str(spec.urdf), pinocchio.GeometryType.COLLISION, package_dirs=[str(spec.urdf.parent)]
    )
    clouds: dict[str, list[np.ndarray]] = {}
    for item in geometry.geometryObjects:
        vertices = np.array(item.geometry.vertices()) * item.meshScale
        frame = model.frames[item.parentFrame]
        T = (frame.placement.inverse() * item.placement).homogeneous
        clouds.setdefault(frame.name, []).append(vertices @ T[:3, :3].T + T[:3, 3])
    return spec, model, {name: Body.of([c[ConvexHull(c).vertices] for c in cloud]) for name, cloud in clouds.items()}


def links_along(configurations: np.ndarray, opening: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """T_world_link of every link, and T_world_tool, each of shape (n, 4, 4)."""
    spec, model, bodies = robot()
    data, full = model.createData(), np.zeros(model.nq)
    columns = [model.joints[model.getJointId(name)].idx_q for name in (*spec.joints, *spec.gripper.joints)]
    frames = {name: model.getFrameId(name) for name in (*bodies, spec.tool_parent)}
    placed = {name: np.empty((len(configurations), 4, 4)) for name in frames}
    for k, q in enumerate(configurations):
        full[columns] = (*q, opening / 2, opening / 2)
        pinocchio.framesForwardKinematics(model, data, full)
        for name, frame in frames.items():
            placed[name][k] = data.oMf[frame].homogeneous
    base = spec.T_world_base.matrix
    placed = {name: base @ T for name, T in placed.items()}
    return placed, placed[spec.tool_parent] @ spec.T_parent_tool.matrix


def tool_at(q: np.ndarray) -> np.ndarray:
    return links_along(q[None], 0.0)[1][0]
