"""What lies between the pads of a grasp, felt along rays from one pad to the other, and the forces on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.surfaces import half_spaces
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Gripper, Pose
from tamp.task.robot import PAD_FRICTION

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

RAYS = (5, 13)  # across and along a pad, at which the object is felt
BESIDE = 0.01  # parts that are farther than this from where the pads are play no role [m]
GRAVITY = 9.81  # [m/s^2]


@dataclass(frozen=True, eq=False)
class Side:
    """What one pad feels, ray by ray.

    Attributes:
        points: on the surface, shape (n, 3) [m].
        normals: of the faces there, outward, shape (n, 3).
    """

    points: Array
    normals: Array

    @property
    def heights(self) -> Array:
        """How far the points are along the closing direction, shape (n,) [m]."""
        heights: Array = self.points[:, 1]
        return heights


class Squeezed:
    """An object in a grasp, in the frame whose axes are the pads' side, closing and approach directions.

    Attributes:
        width: how far the pads are apart [m].
        center: centre of mass, shape (3,) [m].
        weight: of the object [N].
        force: what each pad presses with [N].
        friction: the most that each pad holds along its face [N].
    """

    def __init__(self, workspace: Workspace, obj: str, grasp: Grasp) -> None:
        item, geometry = workspace.task.object(obj), workspace.world.geometries[obj]
        gripper = workspace.world.robot.spec.gripper
        self._R, t = _in_pads(gripper, grasp)
        self.width = grasp.width
        self.center = self._R @ geometry.center_of_mass + t
        self.weight = item.mass * GRAVITY
        self.force = gripper.holding_force(self.weight, item.friction)
        self.friction = PAD_FRICTION * item.friction * self.force
        near = [part for part in geometry.parts if _is_near(part.vertices @ self._R.T + t, gripper, grasp.width)]
        parts = [(A @ self._R.T, b + A @ self._R.T @ t) for A, b in map(half_spaces, near)]
        self._A = np.concatenate([A for A, _ in parts]) if parts else np.empty((0, 3))
        self._b = np.concatenate([b for _, b in parts]) if parts else np.empty(0)
        self._starts = np.cumsum([0, *(len(b) for _, b in parts)])[:-1]
        sides = zip(gripper.pad[1:], RAYS, strict=True)
        across, along = (np.linspace(-side / 2, side / 2, count) for side, count in sides)
        self._origins = np.array([(x, 0.0, z) for x in across for z in along])

    def upward(self, *poses: Pose) -> Array:
        """The world's upward direction where the object is lifted from each of some poses, repeats left out, (n, 3)."""
        upward = np.unique(np.round([pose.matrix[2, :3] for pose in poses], 6), axis=0)
        return np.asarray(upward @ self._R.T)

    def apart_turned(self, turns: Array) -> Array:
        """How far apart the pads stand with all of it turned, for each of the rotations (n, 3, 3); shape (n,) [m]."""
        A = self._A @ turns.transpose(0, 2, 1)
        return self._apart(A, self._b[:, None] - A @ self._origins.T)

    def apart_shifted(self, shifts: Array) -> Array:
        """The same with all of it moved, for each of the vectors (n, 3) [m]."""
        moved = self._b[:, None] - self._A @ self._origins.T + (shifts @ self._A.T)[:, :, None]
        return self._apart(np.broadcast_to(self._A, (len(shifts), *self._A.shape)), moved)

    def sides(self) -> tuple[Side, Side]:
        """What the pad at the beginning of the rays feels and what the one at their end does, where rays meet it."""
        if not len(self._b):
            return (Side(np.empty((0, 3)), np.empty((0, 3))),) * 2
        t, enter, leave, met = self._crossings(self._A[None], (self._b[:, None] - self._A @ self._origins.T)[None])
        t, enter, leave, met = t[0], enter[0], leave[0], met[0]
        owners = np.repeat(np.arange(len(self._starts)), np.diff([*self._starts, len(self._b)]))
        rays = np.flatnonzero(met.any(axis=0))

        def side(first: Array, parts: Array) -> Side:
            reached = first[parts, rays]
            face = ((t[:, rays] == reached) & (owners[:, None] == parts)).argmax(axis=0)
            return Side(self._origins[rays] + reached[:, None] * [0.0, 1.0, 0.0], self._A[face])

        low, high = np.where(met, enter, np.inf), np.where(met, leave, -np.inf)
        return side(low, low.argmin(axis=0)[rays]), side(high, high.argmax(axis=0)[rays])

    def _apart(self, A: Array, gap: Array) -> Array:
        """From the normals (n, m, 3) of all faces and how far inside each the rays begin, (n, m, rays) [m]."""
        if not A.shape[1]:
            return np.zeros(len(A))
        _, enter, leave, met = self._crossings(A, gap)
        low = np.where(met, enter, np.inf).min(axis=(1, 2))
        high = np.where(met, leave, -np.inf).max(axis=(1, 2))
        apart: Array = np.maximum(high - low, 0.0)
        return apart

    def _crossings(self, A: Array, gap: Array) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
        """Where rays cross the plane of each face, where they enter and leave each part [m], and which they meet."""
        speed = A[:, :, 1:2]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / speed
        enter = np.maximum.reduceat(np.where(speed < -1e-9, t, -np.inf), self._starts, axis=1)
        leave = np.minimum.reduceat(np.where(speed > 1e-9, t, np.inf), self._starts, axis=1)
        met = (enter < leave) & (np.abs(enter + leave) < self.width + 0.002)
        along = np.abs(speed) <= 1e-9  # faces that the rays run along
        if along.any():
            met &= ~np.logical_or.reduceat(along & (gap < 0), self._starts, axis=1)
        return t, enter, leave, met


def _in_pads(gripper: Gripper, grasp: Grasp) -> tuple[Array, Array]:
    """Rotation and translation from the object's frame to one whose axes are the pads' side, closing and approach."""
    closing = np.array(gripper.axis)
    axes = np.stack([np.cross(closing, [0.0, 0.0, 1.0]), closing, [0.0, 0.0, 1.0]])
    T = grasp.T_object_tool.inverse().matrix
    return axes @ T[:3, :3], axes @ T[:3, 3]


def _is_near(points: Array, gripper: Gripper, width: float) -> bool:
    half = np.array([gripper.pad[1], width, gripper.pad[2]]) / 2 + BESIDE
    return bool((points.min(axis=0) < half).all() and (points.max(axis=0) > -half).all())
