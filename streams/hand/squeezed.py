"""An object between the pads of a gripper: its convex parts there, and how far apart they hold the pads."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.task.robot import PAD_FRICTION
from tamp.world.geometry.half_spaces import half_spaces, joined
from tamp.world.robot.linkage import Linkage
from tamp.world.robot.payload import GRAVITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry.half_spaces import Planes
    from tamp.world.geometry.object_geometry import Geometry

    Array = NDArray[np.float64]

RAYS = (5, 13)  # across and along a pad, at which the object is felt
BESIDE = 0.01  # parts that are farther than this from where the pads are play no role [m]
ROUNDING = 1e-9  # [m]


class Squeezed:
    """An object in a grasp, in the frame whose axes are the pads' side, closing and approach directions.

    Attributes:
        width: how far the pads are apart [m].
        center: centre of mass, shape (3,) [m].
        weight: of the object [N].
        force: what each pad presses with [N].
        friction: the most that each pad holds along its face [N].
        across: from corner to corner of a pad [m].
    """

    def __init__(self, workspace: Workspace, obj: str, grasp: Grasp) -> None:
        item, geometry = workspace.task.object(obj), workspace.world.geometries[obj]
        gripper = workspace.world.robot.spec.gripper
        R, t = in_pads(workspace.world.robot.linkage, grasp)
        self._R, self._pad, self.width = R, gripper.pad, grasp.width
        self.center = R @ geometry.center_of_mass + t
        self.weight = item.mass * GRAVITY
        self.force = gripper.holding_force(self.weight, item.friction)
        self.friction = PAD_FRICTION * item.friction * self.force
        self.across = math.hypot(*gripper.pad[1:])
        corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * (geometry.upper - geometry.lower).mean()
        self._cube = corners @ R.T + t
        half = np.array([gripper.pad[1], grasp.width, gripper.pad[2]]) / 2 + BESIDE
        pieces = workspace.cache.value(("pieces", obj), lambda: Pieces.of(geometry))
        self._planes, self._balls = pieces.within(R, t, half)

    def displaced(self, turn: Array) -> float:
        """How far a turn about the pads' middle, a rotation (3, 3), takes the object, as the score measures it [m]."""
        return float(np.linalg.norm(self._cube @ (turn - np.eye(3)).T, axis=1).mean())

    def upward(self, *poses: Pose) -> Array:
        """The world's upward direction where the object is lifted from each of some poses, repeats left out, (n, 3)."""
        upward = {tuple(np.round(pose.matrix[2, :3], 6).tolist()) for pose in poses}
        return np.asarray(np.array(sorted(upward)) @ self._R.T)

    def apart_turned(self, turns: Array, rim: float = 0.0) -> Array:
        """How far apart the pads stand with all of it turned, for each of the rotations (n, 3, 3); shape (n,) [m].

        The outermost part of the pads, `rim` wide [m], counts for nothing.
        """
        return self._apart(turns, np.zeros((len(turns), 3)), rim)

    def apart_shifted(self, shifts: Array) -> Array:
        """The same with all of it moved, for each of the vectors (n, 3) [m]."""
        return self._apart(np.tile(np.eye(3), (len(shifts), 1, 1)), shifts, 0.0)

    def _apart(self, turns: Array, shifts: Array, rim: float) -> Array:
        origins = _rays(self._pad, rim)
        return _apart(self._planes, self._balls, origins, self.width, turns, shifts)


@lru_cache(maxsize=64)
def _rays(pad: tuple[float, float, float], rim: float) -> Array:
    """Where the rays along the closing axis begin: midway between two pads whose rims count for nothing, (r, 3) [m]."""
    sides = zip(pad[1:], RAYS, strict=True)
    across, along = (np.linspace(rim - side / 2, side / 2 - rim, count) for side, count in sides)
    return np.array([(x, 0.0, z) for x in across for z in along])


@dataclass(frozen=True, eq=False)
class Pieces:
    """The convex parts of a body, one after the other.

    Attributes:
        vertices: of all parts, shape (n, 3) [m].
        starts: where each part's vertices begin among them, shape (parts,).
        planes: of all parts.
        balls: a centre and a radius for each part, of a ball around it, shape (parts, 4) [m].
    """

    vertices: Array
    starts: NDArray[np.int64]
    planes: Planes
    balls: Array

    @staticmethod
    def of(geometry: Geometry) -> Pieces:
        """Those of a body, in its frame."""
        counts = [len(part.vertices) for part in geometry.parts]
        vertices, starts = np.concatenate([part.vertices for part in geometry.parts]), np.cumsum([0, *counts[:-1]])
        low, high = np.minimum.reduceat(vertices, starts), np.maximum.reduceat(vertices, starts)
        middles = (low + high) / 2
        reach = np.linalg.norm(vertices - np.repeat(middles, counts, axis=0), axis=1)
        balls = np.column_stack([middles, np.maximum.reduceat(reach, starts)])
        return Pieces(vertices, starts, joined(map(half_spaces, geometry.parts)), balls)

    def within(self, R: Array, t: Array, half: Array) -> tuple[Planes, Array]:
        """Planes and balls of those that are, moved by R (3, 3) and t (3,) [m], in a box about the origin.

        The box is half as wide as `half`, shape (3,) [m].
        """
        moved = self.vertices @ R.T + t
        low, high = np.minimum.reduceat(moved, self.starts), np.maximum.reduceat(moved, self.starts)
        near = (low < half).all(axis=1) & (high > -half).all(axis=1)
        A, b, ends = self.planes
        counts = np.diff(ends, prepend=0)
        kept = np.repeat(near, counts)
        turned = np.ascontiguousarray(A[kept] @ R.T)
        planes = turned, b[kept] + turned @ t, np.cumsum(counts[near])
        balls = np.column_stack([self.balls[near, :3] @ R.T + t, self.balls[near, 3]])
        return planes, balls


@compiled
def _apart(planes: Planes, balls: Array, origins: Array, width: float, turns: Array, shifts: Array) -> Array:
    """How far apart rays along the closing axis, from origins (r, 3), say that the pads stand, shape (n,) [m].

    Args:
        planes: of the convex parts that lie between the pads.
        balls: a centre and a radius for each part, of a ball around it, (parts, 4) [m].
        origins: where the rays begin: midway between the pads.
        width: what meets a ray farther from its beginning than half of this lies beyond the pads [m].
        turns: the parts are turned by each of these, shape (n, 3, 3),
        shifts: and then moved by these, shape (n, 3) [m].
    """
    A, b, ends = planes
    apart, turned, offset = np.empty(len(turns)), np.empty((len(A), 3)), np.empty(len(A))
    for k in range(len(turns)):
        for m in range(len(A)):
            offset[m] = b[m]
            for i in range(3):
                turned[m, i] = turns[k, i, 0] * A[m, 0] + turns[k, i, 1] * A[m, 1] + turns[k, i, 2] * A[m, 2]
                offset[m] += turned[m, i] * shifts[k, i]
        low, high, first = np.inf, -np.inf, 0
        for part in range(len(ends)):
            ball, end = balls[part], ends[part]
            x = turns[k, 0, 0] * ball[0] + turns[k, 0, 1] * ball[1] + turns[k, 0, 2] * ball[2] + shifts[k, 0]
            z = turns[k, 2, 0] * ball[0] + turns[k, 2, 1] * ball[1] + turns[k, 2, 2] * ball[2] + shifts[k, 2]
            for ray in range(len(origins)):
                if (origins[ray, 0] - x) ** 2 + (origins[ray, 2] - z) ** 2 > (ball[3] + ROUNDING) ** 2:
                    continue
                enter, leave = _crossed(turned[first:end], offset[first:end], origins[ray])
                if enter < leave and abs(enter + leave) < width + 0.002:
                    low, high = min(low, enter), max(high, leave)
            first = end
        apart[k] = max(high - low, 0.0)
    return apart


@compiled
def _crossed(A: Array, b: Array, origin: Array) -> tuple[float, float]:
    """Where a ray along y from an origin (3,) enters and leaves the body A x <= b; it leaves first where it misses."""
    enter, leave = -np.inf, np.inf
    for m in range(len(A)):
        gap = b[m] - A[m, 0] * origin[0] - A[m, 1] * origin[1] - A[m, 2] * origin[2]
        if A[m, 1] > 1e-9:
            leave = min(leave, gap / A[m, 1])
        elif A[m, 1] < -1e-9:
            enter = max(enter, gap / A[m, 1])
        elif gap < 0.0:
            return np.inf, -np.inf
        if enter >= leave:
            return np.inf, -np.inf
    return enter, leave


@lru_cache(maxsize=64)
def _axes(closing: tuple[float, float, float]) -> Array:
    """The pads' side, closing and approach directions as rows, shape (3, 3), in the tool's frame."""
    return np.stack([np.cross(closing, [0.0, 0.0, 1.0]), closing, [0.0, 0.0, 1.0]])


def in_pads(linkage: Linkage, grasp: Grasp) -> tuple[Array, Array]:
    """Rotation and translation from the object's frame to one whose axes are the pads' side, closing and approach."""
    axes = _axes(linkage.gripper.axis)
    T = grasp.T_object_tool.inverse().matrix
    return axes @ T[:3, :3], axes @ T[:3, 3] - (0.0, 0.0, float(linkage.depth(grasp.width)))
