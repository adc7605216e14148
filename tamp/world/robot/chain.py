"""The arm as a chain of joints in plain arrays, for many configurations at once, and for compiled loops."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.errors import RobotError
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Chain:
    """Constants of a serial arm, taken from Pinocchio's model; n joints.

    Attributes:
        turn: per joint the three matrices whose sum, weighted by (1, sin q, 1 - cos q), rotates from the joint before,
            shape (n, 3, 3, 3) (Rodrigues' formula with the joint's placement multiplied in).
        offset: origin of each joint in the frame of the one before, shape (n, 3) [m].
        axis: each joint's axis in its own frame, shape (n, 3).
        slides: whether a joint is prismatic, shape (n,).
        tool: `T_last_tool`, shape (4, 4).
    """

    turn: Array
    offset: Array
    axis: Array
    slides: NDArray[np.bool_]
    tool: Array

    def frames(self, q: Array) -> Array:
        """Each joint's frame in the world at configurations `q`, shape (b, n): shape (n, b, 4, 4)."""
        count, joints = q.shape
        frames = np.zeros((joints, count, 4, 4))
        frames[..., 3, 3] = 1.0
        angle = np.where(self.slides, 0.0, q).T
        weights = np.stack([np.ones_like(angle), np.sin(angle), 1.0 - np.cos(angle)], axis=-1)
        frames[..., :3, :3] = (weights @ self.turn.reshape(joints, 3, 9)).reshape(joints, count, 3, 3)
        frames[..., :3, 3] = self.offset[:, None]
        for i in np.flatnonzero(self.slides).tolist():
            frames[i, :, :3, 3] += q[:, i, None] * (self.turn[i, 0] @ self.axis[i])
        for i in range(1, joints):
            np.matmul(frames[i - 1], frames[i], out=frames[i])
        return frames

    def forward(self, q: Array) -> tuple[Array, Array]:
        """Tool rotations (b, 3, 3) and positions (b, 3) [m] in the world at configurations `q`, shape (b, n)."""
        T = self.frames(q)[-1] @ self.tool
        return T[:, :3, :3], T[:, :3, 3]


@cache
def chain(robot: RobotModel) -> Chain:
    """The chain from the world to the robot's tool.

    Raises:
        RobotError: where the arm's joints are not one chain in the order of the robot's data, or one of them neither
            turns about nor slides along a single axis.
    """
    model, spec = robot.model, robot.spec
    joints = [model.getJointId(name) for name in spec.joints]
    if any(model.parents[b] != a for a, b in zip([0, *joints], joints, strict=False)) or joints[-1] != robot.tool_joint:
        raise RobotError(f"robot {spec.name}: arm joints {', '.join(spec.joints)} are not one chain from base to tool")
    turn, offset, axis, slides = [], [], [], []
    for joint in joints:
        subspace = _motion_axis(robot, joint)
        slide = bool(np.abs(subspace[:3]).max() > 0.5)
        a = subspace[:3] if slide else subspace[3:]
        skew = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
        placement = model.jointPlacements[joint]
        turn.append([placement.rotation, placement.rotation @ skew, placement.rotation @ skew @ skew])
        offset.append(placement.translation)
        axis.append(a)
        slides.append(slide)
    return Chain(np.array(turn), np.array(offset), np.array(axis), np.array(slides), robot.T_joint_tool)


def _motion_axis(robot: RobotModel, joint: int) -> Array:
    """The joint's unit velocity in its own frame, (linear, angular), shape (6,): its Jacobian's own column."""
    import pinocchio as pin

    model = robot.model
    if model.joints[joint].nv != 1 or model.joints[joint].nq != 1:
        raise RobotError(f"robot {robot.spec.name}: joint {model.names[joint]} has not exactly one coordinate")
    jacobian = pin.computeJointJacobian(model, model.createData(), pin.neutral(model), joint)
    column: Array = jacobian[:, model.joints[joint].idx_v]
    return column
