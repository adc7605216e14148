"""The Levenberg-Marquardt method on a batch of configurations, each towards its own tool pose.

The damping follows Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", IEEE
Transactions on Robotics, 2011.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

POSITION_TOLERANCE = 1e-6  # [m]; ten times finer than promised
ANGLE_TOLERANCE = 1e-5  # [rad]
METRES_PER_RADIAN = 0.25
"""What turning the tool by a radian weighs against moving it, when errors are compared."""
ITERATIONS = 30


def levenberg_marquardt(
    robot: RobotModel, starts: Array, goals: Array, patience: int, enough: int | None = None
) -> tuple[Array, Array]:
    """Drive configurations towards tool poses, within the position limits.

    Args:
        robot: the robot.
        starts: shape (b, dof) [rad].
        goals: `T_world_tool`, one of shape (4, 4) or one for each start, shape (b, 4, 4).
        patience: iterations that every start is granted.
        enough: stop when so many have reached their goals; default all.

    Returns:
        Configurations, shape (b, dof), and how far the tool is from its goal at each: 0 where within tolerance, else
        in metres, a radian weighing `METRES_PER_RADIAN`.

    Near a solution the error falls quadratically. A start whose error no longer halves after `patience` iterations
    sits in a corner of the limits or in a local minimum, and is dropped.
    """
    arm = chain(robot)
    lower, upper = robot.lower, robot.upper
    q = np.clip(starts, lower, upper)
    goals = np.broadcast_to(goals, (len(q), 4, 4))
    most = len(q) if enough is None else enough
    active, residual = np.arange(len(q)), np.full(len(q), np.inf)
    for iteration in itertools.count():
        R, p, jacobian = arm.forward(q[active])
        error = _pose_error(goals[active], R, p)
        squares = error * error
        distance, angle = squares[:, :3].sum(axis=1), squares[:, 3:].sum(axis=1)
        reached = (distance < POSITION_TOLERANCE**2) & (angle < ANGLE_TOLERANCE**2)
        size = np.where(reached, 0.0, np.sqrt(distance + METRES_PER_RADIAN**2 * angle))
        going = ~reached & ((size < 0.5 * residual[active]) | (iteration < patience))
        residual[active] = size
        active, error, jacobian = active[going], error[going], jacobian[going]
        if len(active) == 0 or iteration == ITERATIONS or np.count_nonzero(residual == 0.0) >= most:
            break
        q[active] = np.clip(q[active] + _step(jacobian, error), lower, upper)
    return q, residual


def _step(jacobian: Array, error: Array) -> Array:
    """Damped least-squares steps, shape (b, n): J^T (J J^T + (e^T e / 2 + 1e-6) I)^-1 e, none over half a radian."""
    normal = jacobian @ jacobian.transpose(0, 2, 1)
    damping = 0.05 * np.einsum("ij,ij->i", error, error) + 1e-9
    normal[:, range(6), range(6)] += damping[:, None]
    step: Array = np.einsum("bij,bi->bj", jacobian, np.linalg.solve(normal, error[..., None])[..., 0])
    largest = np.abs(step).max(axis=1)
    step *= np.minimum(1.0, 0.5 / np.maximum(largest, 1e-12))[:, None]
    return step


def _pose_error(goal: Array, R: Array, p: Array) -> Array:
    """What is missing to the goals, (translation, rotation vector) in world axes, shape (b, 6)."""
    error = np.empty((len(p), 6))
    error[:, :3] = goal[:, :3, 3] - p
    error[:, 3:] = rotation_vector(goal[:, :3, :3] @ R.transpose(0, 2, 1))
    return error


def rotation_vector(R: Array) -> Array:
    """Axis times angle [rad] of rotations, shape (b, 3, 3) -> (b, 3); near half a turn the axis is approximate."""
    skew = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
    sine = np.linalg.norm(skew, axis=1) / 2
    angle = np.arctan2(sine, (np.trace(R, axis1=1, axis2=2) - 1) / 2)
    flipped = (sine < 1e-6) & (angle > 1.0)
    vector = skew * (np.where(sine < 1e-9, 0.5, angle / (2 * np.maximum(sine, 1e-9))))[:, None]
    if flipped.any():
        # Half a turn: R = 2 a a^T - I, any sign of the axis will do.
        column = np.argmax(np.diagonal(R[flipped], axis1=1, axis2=2), axis=1)
        axis = R[flipped][np.arange(len(column)), :, column]
        axis[np.arange(len(column)), column] += 1.0
        vector[flipped] = axis / np.linalg.norm(axis, axis=1)[:, None] * angle[flipped, None]
    return vector
