"""An object between the pads of a gripper: its convex parts there, and how far apart they hold the pads."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.hand.pad_gap import apart, turned, within
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.task.robot import PAD_FRICTION
from tamp.world.geometry.half_spaces import half_spaces, joined
from tamp.world.robot.linkage import Linkage
from tamp.world.robot.payload import GRAVITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.streams.hand.pad_gap import Between
    from tamp.world.geometry.half_spaces import Planes
    from tamp.world.geometry.object_geometry import Geometry

    Array = NDArray[np.float64]

RAYS = (5, 13)  # across and along a pad, at which the object is felt
BESIDE = 0.01  # parts that are farther than this from where the pads are play no role [m]


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

    def apart_shifted(self, shifts: Array) -> Array:
        """How far apart the pads stand with all of it moved, for each of the vectors (n, 3) [m]; shape (n,) [m]."""
        return apart(self._between(0.0), np.tile(np.eye(3), (len(shifts), 1, 1)), shifts)

    def turned(self, force: float, resisted: float, up: Array | None = None, rim: float = 0.0) -> Array:
        """The rotation that it makes until pads that press on it come no nearer, shape (3, 3).

        Args:
            force: that each pad presses with [N].
            resisted: what friction takes of the energy for each step of `TURN_STEP` [J].
            up: the upward direction, shape (3,), where its weight turns it as well.
            rim: the outermost part of the pads, so wide, counts for nothing [m].
        """
        pull = np.zeros((3, 3)) if up is None else self.weight * np.outer(up, self.center)
        return turned(self._between(rim), force, pull, resisted)

    def _between(self, rim: float) -> Between:
        return self._planes, self._balls, _rays(self._pad, rim), self.width


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
        return within(self.vertices, self.starts, self.planes, self.balls, np.ascontiguousarray(R), t, half)


def in_pads(linkage: Linkage, grasp: Grasp) -> tuple[Array, Array]:
    """Rotation and translation from the object's frame to one whose axes are the pads' side, closing and approach."""
    T_object_tool = grasp.T_object_tool.matrix
    R = linkage.axes @ T_object_tool[:3, :3].T
    return R, -(R @ T_object_tool[:3, 3]) - (0.0, 0.0, float(linkage.depth(grasp.width)))
