"""The hand alone: its shape seen from the tool frame, and as a free body among things that keep still."""

from __future__ import annotations

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
        # Fingers, which are hit most often, are named last.
        self._bodies = [(Probe(shape), way) for shape, way in reversed(_bodies(robot))]

    def hits(self, T_world_tool: Matrix, openings: Vector) -> NDArray[np.bool_]:
        """Whether each hand comes too close to anything, shape (n,).

        Args:
            T_world_tool: where the tool is, shape (n, 4, 4).
            openings: distances between the finger pads, shape (n,) [m].
        """
        hit = np.zeros(len(openings), bool)
        for probe, way in self._bodies:
            R_tool_body, local = way.at(openings)
            R = T_world_tool[:, :3, :3] @ R_tool_body
            t = np.einsum("nij,nj->ni", T_world_tool[:, :3, :3], local) + T_world_tool[:, :3, 3]
            left = np.flatnonzero(~hit)
            hit[left] = self._crowd.meets(probe, R[left], t[left])
        return hit

    def hit(self, T_world_tool: Matrix, opening: float) -> bool:
        """Whether one hand, shape (4, 4), comes too close to anything."""
        R, t = T_world_tool[:3, :3], T_world_tool[:3, 3]
        for probe, way in self._bodies:
            R_tool_body, local = way.at_one(opening)
            if self._crowd.meets(probe, (R @ R_tool_body)[None], (R @ local + t)[None])[0]:
                return True
        return False


@dataclass(frozen=True, eq=False)
class _Way:
    """Where a body of the hand is in the tool frame as the gripper opens: straight between tabulated openings.

    Attributes:
        grid: the openings, shape (g,) [m].
        T: its pose at each, shape (g, 4, 4).
        rate: how the pose changes for a metre of opening from each on, shape (g - 1, 4, 4).
        turns: whether its orientation changes.
    """

    grid: Vector
    T: Matrix
    rate: Matrix
    turns: bool

    def at(self, openings: Vector) -> tuple[Matrix, Matrix]:
        """Rotations, (3, 3) where they are all the same or (n, 3, 3), and positions (n, 3) at openings (n,) [m]."""
        i = np.clip(np.searchsorted(self.grid, openings, side="right") - 1, 0, len(self.rate) - 1)
        beyond = (openings - self.grid[i])[:, None]
        position = self.T[i, :3, 3] + beyond * self.rate[i, :3, 3]
        if not self.turns:
            return self.T[0, :3, :3], position
        return self.T[i, :3, :3] + beyond[:, :, None] * self.rate[i, :3, :3], position

    def at_one(self, opening: float) -> tuple[Matrix, Matrix]:
        """Rotation (3, 3) and position (3,) at an opening [m]."""
        i = 0 if len(self.rate) == 1 else int(np.clip(np.searchsorted(self.grid, opening) - 1, 0, len(self.rate) - 1))
        beyond = opening - self.grid[i]
        position = self.T[i, :3, 3] + beyond * self.rate[i, :3, 3]
        if not self.turns:
            return self.T[0, :3, :3], position
        return self.T[i, :3, :3] + beyond * self.rate[i, :3, :3], position


@cache
def _bodies(robot: RobotModel) -> tuple[tuple[Solid, _Way], ...]:
    """Each hull of the hand, and where it is as the gripper opens."""
    grid = robot.linkage.grid
    poses = np.array([hand_poses(robot, opening) for opening in grid])
    rates = np.diff(poses, axis=0) / np.diff(grid)[:, None, None, None]
    return tuple(
        (
            solid([robot.bodies[index].hull]),
            _Way(grid, poses[:, k], rates[:, k], bool(np.abs(rates[:, k, :3, :3]).max() > 1e-9)),
        )
        for k, index in enumerate(robot.hand)
    )
