"""The Levenberg-Marquardt method on a batch of configurations, each towards its own tool pose.

The damping follows Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", IEEE
Transactions on Robotics, 2011.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.world.kinematics.freedom import confined
from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Links = tuple[Array, Array, Array, NDArray[np.bool_], Array]
    """The attributes of `Chain`: turn, offset, axis, slides, tool."""

POSITION_TOLERANCE = 1e-6  # [m]; ten times finer than promised
ANGLE_TOLERANCE = 1e-5  # [rad]
NEAREST_POSITION, NEAREST_ANGLE = 2e-4, 2e-3
"""How far from its goal [m, rad] the nearest tool pose may be of an arm that cannot turn its tool every way: what has
come to rest is off upright by a tenth of that, which such an arm could not follow."""
METRES_PER_RADIAN = 0.25
"""What turning the tool by a radian weighs against moving it, when errors are compared."""
ITERATIONS = 30
FARTHEST_STEP = 0.5
"""No joint moves farther in an iteration [rad]."""


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
        in metres, a radian weighing `METRES_PER_RADIAN`. A confined arm is within tolerance where it gets as near to
        its goal as `NEAREST_POSITION` and `NEAREST_ANGLE`.

    Near a solution the error falls quadratically. A start whose error no longer halves after `patience` iterations
    sits in a corner of the limits or in a local minimum, and is dropped.
    """
    arm, q = chain(robot), np.clip(starts, robot.lower, robot.upper)
    goals = np.array(goals, dtype=np.float64, order="C").reshape(-1, 4, 4)
    links = (arm.turn, arm.offset, arm.axis, arm.slides, arm.tool)
    residual: Array = _iterate(
        links, robot.lower, robot.upper, q, goals, patience, len(q) if enough is None else enough
    )
    if confined(robot):
        residual[_nearest(*arm.forward(q), goals)] = 0.0
    return q, residual


def _nearest(R: Array, position: Array, goals: Array) -> NDArray[np.bool_]:
    """Whether each of many tools (b, 3, 3), (b, 3) is as near to its goal as is asked of a confined arm, shape (b,)."""
    turned = np.linalg.norm(rotation_vector(goals[:, :3, :3] @ R.transpose(0, 2, 1)), axis=1)
    away = np.linalg.norm(goals[:, :3, 3] - position, axis=1)
    near: NDArray[np.bool_] = (away < NEAREST_POSITION) & (turned < NEAREST_ANGLE)
    return near


def rotation_vector(R: Array) -> Array:
    """Axis times angle [rad] of rotations, shape (b, 3, 3) -> (b, 3); near half a turn the axis is approximate."""
    return np.array([_rotation_vector(each) for each in np.array(R, dtype=np.float64, order="C")]).reshape(-1, 3)


@compiled
def _iterate(
    links: Links,
    lower: Array,
    upper: Array,
    q: Array,
    goals: Array,
    patience: int,
    enough: int,
) -> Array:
    """Move configurations (b, n) in place, all by one iteration after the other; their residuals, shape (b,)."""
    count, joints = q.shape
    residual, going = np.full(count, np.inf), np.ones(count, np.bool_)
    error, jacobian = np.empty((count, 6)), np.empty((count, 6, joints))
    frames, normal, step = np.zeros((joints + 1, 3, 4)), np.empty((6, 6)), np.empty(joints)
    for r in range(3):
        frames[0, r, r] = 1.0
    for iteration in range(ITERATIONS + 1):
        alive, reached = 0, 0
        for b in range(count):
            if going[b]:
                _linearize(links, q[b], goals[b % len(goals)], frames, error[b], jacobian[b])
                far = _distance(error[b])
                going[b] = far > 0.0 and (far < 0.5 * residual[b] or iteration < patience)
                residual[b] = far
            alive += going[b]
            reached += residual[b] == 0.0
        if alive == 0 or iteration == ITERATIONS or reached >= enough:
            break
        for b in range(count):
            if going[b]:
                _step(jacobian[b], error[b], normal, step)
                for i in range(joints):
                    q[b, i] = min(max(q[b, i] + step[i], lower[i]), upper[i])
    return residual


@compiled
def _distance(error: Array) -> float:
    """How far a tool is from its goal [m]; 0 where within tolerance."""
    distance = error[0] ** 2 + error[1] ** 2 + error[2] ** 2
    angle = error[3] ** 2 + error[4] ** 2 + error[5] ** 2
    if distance < POSITION_TOLERANCE**2 and angle < ANGLE_TOLERANCE**2:
        return 0.0
    return math.sqrt(distance + METRES_PER_RADIAN**2 * angle)


@compiled
def _linearize(
    links: Links,
    q: Array,
    goal: Array,
    frames: Array,
    error: Array,
    jacobian: Array,
) -> None:
    """Write what is missing to a goal, (translation, rotation vector) in world axes (6,), and the Jacobian (6, n).

    `frames`, shape (n + 1, 3, 4), is for the joints' frames in the world, the world's own first.
    """
    turn, offset, axis, slides, tool = links
    joints = len(q)
    local = np.empty((3, 4))
    for i in range(joints):
        sine = 0.0 if slides[i] else math.sin(q[i])
        versine = 0.0 if slides[i] else 1.0 - math.cos(q[i])
        for r in range(3):
            for c in range(3):
                local[r, c] = turn[i, 0, r, c] + sine * turn[i, 1, r, c] + versine * turn[i, 2, r, c]
            local[r, 3] = offset[i, r]
            if slides[i]:
                for c in range(3):
                    local[r, 3] += q[i] * turn[i, 0, r, c] * axis[i, c]
        _compose(frames[i], local, frames[i + 1])
    _compose(frames[joints], tool, local)
    R = np.empty((3, 3))
    for r in range(3):
        error[r] = goal[r, 3] - local[r, 3]
        for c in range(3):
            R[r, c] = goal[r, 0] * local[c, 0] + goal[r, 1] * local[c, 1] + goal[r, 2] * local[c, 2]
    error[3], error[4], error[5] = _rotation_vector(R)
    for i in range(joints):
        for r in range(3):
            along = (
                frames[i + 1, r, 0] * axis[i, 0] + frames[i + 1, r, 1] * axis[i, 1] + frames[i + 1, r, 2] * axis[i, 2]
            )
            jacobian[r, i], jacobian[3 + r, i] = along, 0.0 if slides[i] else along
        if not slides[i]:
            x, y, z = jacobian[0, i], jacobian[1, i], jacobian[2, i]
            to_x, to_y, to_z = (
                local[0, 3] - frames[i + 1, 0, 3],
                local[1, 3] - frames[i + 1, 1, 3],
                local[2, 3] - frames[i + 1, 2, 3],
            )
            jacobian[0, i], jacobian[1, i] = y * to_z - z * to_y, z * to_x - x * to_z
            jacobian[2, i] = x * to_y - y * to_x


@compiled
def _compose(A: Array, B: Array, out: Array) -> None:
    """Write the product of two poses, of which three rows count each."""
    for r in range(3):
        for c in range(4):
            out[r, c] = A[r, 0] * B[0, c] + A[r, 1] * B[1, c] + A[r, 2] * B[2, c]
        out[r, 3] += A[r, 3]


@compiled
def _step(jacobian: Array, error: Array, normal: Array, step: Array) -> None:
    """Write a damped least-squares step (n,): J^T (J J^T + (e^T e / 20 + 1e-9) I)^-1 e, none over `FARTHEST_STEP`."""
    joints = jacobian.shape[1]
    damping = 1e-9
    for r in range(6):
        damping += 0.05 * error[r] ** 2
    for r in range(6):
        for c in range(r + 1):
            total = damping if r == c else 0.0
            for i in range(joints):
                total += jacobian[r, i] * jacobian[c, i]
            normal[r, c] = total
    solved = np.empty(6)
    for r in range(6):  # Cholesky's factor in place of the lower half, and forward substitution
        for c in range(r + 1):
            total = normal[r, c]
            for k in range(c):
                total -= normal[r, k] * normal[c, k]
            normal[r, c] = math.sqrt(total) if r == c else total / normal[c, c]
        total = error[r]
        for k in range(r):
            total -= normal[r, k] * solved[k]
        solved[r] = total / normal[r, r]
    for back in range(6):
        r = 5 - back
        for k in range(r + 1, 6):
            solved[r] -= normal[k, r] * solved[k]
        solved[r] /= normal[r, r]
    largest = 0.0
    for i in range(joints):
        step[i] = 0.0
        for r in range(6):
            step[i] += jacobian[r, i] * solved[r]
        largest = max(largest, abs(step[i]))
    if largest > FARTHEST_STEP:
        for i in range(joints):
            step[i] *= FARTHEST_STEP / largest


@compiled
def _rotation_vector(R: Array) -> tuple[float, float, float]:
    """The same of one rotation, shape (3, 3)."""
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    sine = math.sqrt(x * x + y * y + z * z) / 2
    angle = math.atan2(sine, (R[0, 0] + R[1, 1] + R[2, 2] - 1.0) / 2)
    if sine < 1e-6 and angle > 1.0:
        # Half a turn: R = 2 a a^T - I, any sign of the axis will do.
        k = 0
        for i in range(1, 3):
            if R[i, i] > R[k, k]:
                k = i
        x, y, z = R[0, k] + (k == 0), R[1, k] + (k == 1), R[2, k] + (k == 2)
        scale = angle / math.sqrt(x * x + y * y + z * z)
    else:
        scale = 0.5 if sine < 1e-9 else angle / (2 * sine)
    return scale * x, scale * y, scale * z
