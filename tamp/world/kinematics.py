"""Inverse kinematics: many configurations for a tool pose, and straight lines of the tool.

Solved from many starts at once by the Levenberg-Marquardt method with the damping of Sugihara ("Solvability-unconcerned
inverse kinematics by the Levenberg-Marquardt method", IEEE T-RO 2011). Starts come from a table of random
configurations, those whose tool pose is nearest to the wanted one: such starts already know the arm, nearly all of them
converge, and since the table is uniform in joint space they spread over the family of solutions of a redundant arm.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from tamp.world.chain import Chain, chain
from tamp.world.robot_model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

POSITION_TOLERANCE = 1e-6  # [m]; ten times finer than promised
ANGLE_TOLERANCE = 1e-5  # [rad]
TABLE_SIZE = 50_000
METRES_PER_RADIAN = 0.25
"""What turning the tool by a radian weighs against moving it, when starts are chosen."""
FAR = 0.3
"""A pose farther than this from all of the table's [m, rad weighed in] is out of reach; reachable ones are within 0.23."""


@dataclass(frozen=True, slots=True)
class _Round:
    """One round of starts.

    Attributes:
        starts: how many.
        patience: after how many iterations a start that no longer halves its error is dropped.
        despair: where nothing has been found and every start stayed farther than this [m], the search ends.
    """

    starts: int
    patience: int
    despair: float


ROUNDS = (_Round(12, 4, 0.15), _Round(24, 6, 0.1), _Round(48, 12, 0.05), _Round(96, 25, 0.02), _Round(192, 25, 0.0))
ITERATIONS = 30
DISTINCT = 0.05
"""Two solutions that differ by less than this in every joint [rad] count as one."""
MAX_JOINT_STEP = 0.3
"""A straight line whose neighbouring waypoints differ by more than this in a joint [rad] is no continuous motion."""


class FreeTest(Protocol):
    """What inverse kinematics wants to know of a collision checker."""

    def free(self, q: Array) -> bool:
        """Whether configuration `q` is free."""
        ...


def inverse(
    robot: RobotModel,
    T_world_tool: Array,
    rng: np.random.Generator,
    *,
    near: Array | None = None,
    count: int = 8,
    checker: FreeTest | None = None,
) -> Iterator[Array]:
    """Yield up to `count` different configurations that put the tool at a pose, shape (dof,) [rad] each.

    Every one is within limits and accurate to 1e-5 m and 1e-4 rad. None are yielded where the pose is out of reach.

    Args:
        robot: the robot.
        T_world_tool: the wanted tool pose, shape (4, 4).
        rng: shuffles the starts; the same state repeats the same solutions.
        near: a configuration; solutions close to it come first, and its neighbourhood is searched too.
        count: at most so many solutions.
        checker: where given, only configurations it calls free.
    """
    found: list[Array] = []
    for starts, effort in _starts(robot, T_world_tool, rng, near):
        q, residual = _levenberg_marquardt(robot, starts, T_world_tool, effort.patience)
        solutions = q[residual == 0.0]
        if near is not None:
            solutions = solutions[np.argsort(np.linalg.norm(solutions - near, axis=1), kind="stable")]
        for q in solutions:
            if any(np.abs(q - other).max() < DISTINCT for other in found):
                continue
            found.append(q)
            if checker is None or checker.free(q):
                yield q
                count -= 1
                if count == 0:
                    return
        if not found and residual.min() > effort.despair:
            return


def straight_line(robot: RobotModel, q: Array, T_goal: Array, step: float = 0.01) -> Array | None:
    """The path, shape (n, dof), along which the tool moves straight from where `q` puts it to `T_goal`.

    Position and rotation are interpolated together, in waypoints at most `step` [m] apart (and 0.1 rad); the first is
    `q` itself. None where a waypoint is out of reach, beyond a limit, or only reached by a jump of the joints.
    """
    T_start = robot.forward(q)
    path = [np.array(q, dtype=np.float64)]
    goals = _interpolated(T_start, T_goal, step)
    for first in range(0, len(goals), 8):
        # All waypoints of a stretch are solved at once from its first configuration: the solution depends smoothly on
        # the waypoint, so neighbours are neighbours.
        block = goals[first : first + 8]
        starts = np.repeat(path[-1][None], len(block), axis=0)
        solved, residual = _levenberg_marquardt(robot, starts, block, patience=6)
        if residual.any():
            return None
        path.extend(solved)
    line = np.array(path)
    if np.abs(np.diff(line, axis=0)).max(initial=0.0) > MAX_JOINT_STEP:
        return None
    return line


def _levenberg_marquardt(robot: RobotModel, starts: Array, goals: Array, patience: int) -> tuple[Array, Array]:
    """Configurations, and how far the tool is from its goal at each: 0 where within tolerance, else [m].

    Near a solution the error falls quadratically. A start whose error no longer halves after `patience` iterations
    sits in a corner of the limits or in a local minimum, and is dropped.
    """
    arm: Chain = chain(robot)
    lower, upper = robot.lower, robot.upper
    q = np.clip(starts, lower, upper)
    goals = np.broadcast_to(goals, (len(q), 4, 4))
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
        if len(active) == 0 or iteration == ITERATIONS:
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


def _interpolated(T_start: Array, T_goal: Array, step: float) -> Array:
    """Poses from start (excluded) to goal along a straight line, shape (n, 4, 4), the tool turning evenly."""
    turn = rotation_vector((T_goal[:3, :3] @ T_start[:3, :3].T)[None])[0]
    angle = float(np.linalg.norm(turn))
    length = float(np.linalg.norm(T_goal[:3, 3] - T_start[:3, 3]))
    count = max(1, math.ceil(length / step - 1e-9), math.ceil(angle / 0.1))
    axis = turn / angle if angle > 1e-12 else np.array([0.0, 0.0, 1.0])
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    poses = np.tile(np.eye(4), (count, 1, 1))
    for k in range(count):
        share = (k + 1) / count
        partial = np.eye(3) + math.sin(share * angle) * skew + (1 - math.cos(share * angle)) * skew @ skew
        poses[k, :3, :3] = partial @ T_start[:3, :3]
        poses[k, :3, 3] = (1 - share) * T_start[:3, 3] + share * T_goal[:3, 3]
    return poses


@dataclass(frozen=True, eq=False)
class _SeedTable:
    """Random configurations, and a tree over their tool poses."""

    configurations: Array
    tree: Any


@cache
def _seed_table(robot: RobotModel) -> _SeedTable:
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(0)
    q = rng.uniform(robot.lower, robot.upper, (TABLE_SIZE, robot.dof))
    features = np.concatenate([_features(*chain(robot).forward(block)[:2]) for block in np.array_split(q, 20)])
    return _SeedTable(q, cKDTree(features))


def _features(R: Array, p: Array) -> Array:
    """Tool poses as points whose distances are metres of motion, shape (b, 9): position and two of the tool's axes."""
    weight = METRES_PER_RADIAN / math.sqrt(2)
    return np.concatenate([p, weight * R[:, :, 0], weight * R[:, :, 2]], axis=1)


def _starts(
    robot: RobotModel, T_world_tool: Array, rng: np.random.Generator, near: Array | None
) -> Iterator[tuple[Array, _Round]]:
    """The starts of each round: around `near`, then the table's next nearest, shuffled within a round."""
    table = _seed_table(robot)
    point = _features(T_world_tool[None, :3, :3], T_world_tool[None, :3, 3])[0]
    if table.tree.query(point)[0] > FAR:
        return
    if near is not None:
        yield np.concatenate([near[None], near + rng.normal(0.0, 0.2, (3, robot.dof))]), _Round(4, 4, np.inf)
    taken = 0
    for effort in ROUNDS:
        _, nearest = table.tree.query(point, k=taken + effort.starts)
        yield table.configurations[rng.permutation(nearest[taken:])], effort
        taken += effort.starts
