"""What lies between the pads of a grasp, felt along rays from one pad to the other, and the forces on it."""

from __future__ import annotations

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

    def _apart(self, A: Array, gap: Array) -> Array:
        """From the normals (n, m, 3) of all faces and how far inside each the rays begin, (n, m, rays) [m]."""
        if not A.shape[1]:
            return np.zeros(len(A))
        speed = A[:, :, 1:2]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / speed
        enter = np.maximum.reduceat(np.where(speed < -1e-9, t, -np.inf), self._starts, axis=1)
        leave = np.minimum.reduceat(np.where(speed > 1e-9, t, np.inf), self._starts, axis=1)
        met = (enter < leave) & (np.abs(enter + leave) < self.width + 0.002)
        along = np.abs(speed) <= 1e-9  # faces that the rays run along
        if along.any():
            met &= ~np.logical_or.reduceat(along & (gap < 0), self._starts, axis=1)
        low = np.where(met, enter, np.inf).min(axis=(1, 2))
        high = np.where(met, leave, -np.inf).max(axis=(1, 2))
        apart: Array = np.maximum(high - low, 0.0)
        return apart


def _in_pads(gripper: Gripper, grasp: Grasp) -> tuple[Array, Array]:
    """Rotation and translation from the object's frame to one whose axes are the pads' side, closing and approach."""
    closing = np.array(gripper.axis)
    axes = np.stack([np.cross(closing, [0.0, 0.0, 1.0]), closing, [0.0, 0.0, 1.0]])
    T = grasp.T_object_tool.inverse().matrix
    return axes @ T[:3, :3], axes @ T[:3, 3]


def _is_near(points: Array, gripper: Gripper, width: float) -> bool:
    half = np.array([gripper.pad[1], width, gripper.pad[2]]) / 2 + BESIDE
    return bool((points.min(axis=0) < half).all() and (points.max(axis=0) > -half).all())
