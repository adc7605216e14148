"""The hand alone: its shape seen from the tool frame, and as a free body among things that keep still."""

from __future__ import annotations

from collections.abc import Iterable
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
        self._bodies = [(Probe(shape), T, travel) for shape, T, travel in reversed(_bodies(robot))]

    def hits(self, T_world_tool: Matrix, openings: Vector) -> NDArray[np.bool_]:
        """Whether each hand comes too close to anything, shape (n,).

        Args:
            T_world_tool: where the tool is, shape (n, 4, 4).
            openings: distances between the finger pads, shape (n,) [m].
        """
        hit = np.zeros(len(openings), bool)
        for probe, T_tool_body, travel in self._bodies:
            R = T_world_tool[:, :3, :3] @ T_tool_body[:3, :3]
            local = T_tool_body[:3, 3] + openings[:, None] * travel
            t = np.einsum("nij,nj->ni", T_world_tool[:, :3, :3], local) + T_world_tool[:, :3, 3]
            for index in np.flatnonzero(~hit):
                hit[index] = self._crowd.meets(probe, R[index], t[index])
        return hit

    def hit(self, T_world_tool: Matrix, opening: float) -> bool:
        """Whether one hand, shape (4, 4), comes too close to anything."""
        R, t = T_world_tool[:3, :3], T_world_tool[:3, 3]
        return any(
            self._crowd.meets(probe, R @ T_tool_body[:3, :3], R @ (T_tool_body[:3, 3] + opening * travel) + t)
            for probe, T_tool_body, travel in self._bodies
        )


@cache
def _bodies(robot: RobotModel) -> tuple[tuple[Solid, Matrix, Vector], ...]:
    """Each hull of the hand, its pose in the tool frame with the pads together, and its way for a metre of opening.

    Fingers are prismatic, so that two openings tell of all others.
    """
    stroke = robot.spec.gripper.stroke
    shapes = (solid([robot.bodies[index].hull]) for index in robot.hand)
    ends = zip(shapes, hand_poses(robot, 0.0), hand_poses(robot, stroke), strict=True)
    return tuple((shape, shut, (wide[:3, 3] - shut[:3, 3]) / stroke) for shape, shut, wide in ends)
