"""The hand alone: its shape seen from the tool frame, and as a free body among things that keep still."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from tamp.world.geometry.convex_union import Crowd, Probe, Solid, solid
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]
    Vector = NDArray[np.float64]


def hand_poses(robot: RobotModel, opening: float) -> tuple[Matrix, ...]:
    """Poses of hand and fingers in the tool frame, in the order of `robot.hand`, shapes (4, 4).

    Args:
        robot: the robot.
        opening: distance between the finger pads [m].
    """
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full(robot.home, opening))
    T_tool_world = (data.oMi[robot.tool_joint] * pin.SE3(robot.T_joint_tool)).inverse()
    return tuple((T_tool_world * data.oMi[robot.bodies[index].joint]).homogeneous for index in robot.hand)


def hand_points(robot: RobotModel, opening: float) -> tuple[Matrix, ...]:
    """Vertices of the convex hulls of hand and fingers in the tool frame, shapes (n, 3) [m]; `opening` as above."""
    poses = zip((robot.bodies[index] for index in robot.hand), hand_poses(robot, opening), strict=True)
    return tuple(body.hull.vertices @ T[:3, :3].T + T[:3, 3] for body, T in poses)


class FreeHand:
    """Hand and fingers that fly free among standing solids. Belongs to one thread."""

    def __init__(self, robot: RobotModel, standing: Iterable[tuple[Solid, Matrix]], margin: float) -> None:
        """Prepare to ask.

        Args:
            robot: whose hand it is.
            standing: what stands around, each with its `T_world_solid`.
            margin: least distance of hand and fingers to everything [m], 0 or more.
        """
        self._crowd = Crowd(standing, margin)
        self._way = _way(robot)
        self._hand = Probe(*_bodies(robot))

    def hits(self, T_world_tool: Matrix, openings: Vector) -> NDArray[np.bool_]:
        """Whether each hand comes too close to anything, shape (n,).

        Args:
            T_world_tool: where the tool is, shape (n, 4, 4).
            openings: distances between the finger pads, shape (n,) [m].
        """
        hit = np.zeros(len(openings), bool)
        for k in range(len(self._hand.bodies)):
            R_tool_body, local = self._way.at(openings, k)
            R = T_world_tool[:, :3, :3] @ R_tool_body
            t = np.einsum("nij,nj->ni", T_world_tool[:, :3, :3], local) + T_world_tool[:, :3, 3]
            left = np.flatnonzero(~hit)
            hit[left] = self._crowd.meets(self._hand, k, R[left], t[left])
        return hit

    def hit(self, T_world_tool: Matrix, opening: float) -> bool:
        """Whether one hand, shape (4, 4), comes too close to anything."""
        R, local = self._way.all_at(opening)
        t = local @ T_world_tool[:3, :3].T + T_world_tool[:3, 3]
        return self._crowd.meets_any(self._hand, T_world_tool[:3, :3] @ R, t)


@dataclass(frozen=True, eq=False)
class _Way:
    """Where the bodies of the hand are in the tool frame as the gripper opens: straight between tabulated openings.

    Attributes:
        grid: the openings, shape (g,) [m].
        R: their orientations at each, shape (g, bodies, 3, 3).
        t: their positions, shape (g, bodies, 3) [m].
        turning: how the orientations change for a metre of opening from each on, shape (g - 1, bodies, 3, 3).
        moving: the same for the positions, shape (g - 1, bodies, 3).
    """

    grid: Vector
    R: Matrix
    t: Matrix
    turning: Matrix
    moving: Matrix

    def at(self, openings: Vector, k: int) -> tuple[Matrix, Matrix]:
        """Rotations (n, 3, 3) and positions (n, 3) [m] of the k-th body at openings (n,) [m]."""
        i = np.clip(np.searchsorted(self.grid, openings, side="right") - 1, 0, len(self.moving) - 1)
        beyond = openings - self.grid[i]
        R = self.R[i, k] + beyond[:, None, None] * self.turning[i, k]
        return R, self.t[i, k] + beyond[:, None] * self.moving[i, k]

    def all_at(self, opening: float) -> tuple[Matrix, Matrix]:
        """Rotations (bodies, 3, 3) and positions (bodies, 3) of all of them at an opening [m]."""
        last = len(self.moving) - 1
        i = 0 if last == 0 else min(max(bisect_left(self.grid, opening) - 1, 0), last)
        beyond = opening - self.grid[i]
        return self.R[i] + beyond * self.turning[i], self.t[i] + beyond * self.moving[i]


@cache
def _way(robot: RobotModel) -> _Way:
    """Where each of `_bodies` is."""
    grid = robot.linkage.grid
    poses = np.array([hand_poses(robot, opening)[::-1] for opening in grid])
    rates = np.diff(poses, axis=0) / np.diff(grid)[:, None, None, None]
    parts = (T[..., :3, column] for column in (slice(3), 3) for T in (poses, rates))
    R, turning, t, moving = map(np.ascontiguousarray, parts)
    return _Way(grid, R, t, turning, moving)


@cache
def _bodies(robot: RobotModel) -> tuple[Solid, ...]:
    """Each hull of the hand: fingers, which are hit most often, come first."""
    return tuple(solid([robot.bodies[index].hull]) for index in reversed(robot.hand))
