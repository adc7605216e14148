"""Inverse kinematics: many configurations for a tool pose, and straight lines of the tool."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from tamp.world.kinematics.levenberg_marquardt import levenberg_marquardt, rotation_vector
from tamp.world.kinematics.seeds import nearest_starts, rounds_of_starts
from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

TRIED = 4
"""So many times more solutions than asked for may turn out in collision before the search ends."""
DISTINCT = 0.05
"""Two solutions that differ by less than this in every joint [rad] count as one."""
MAX_JOINT_STEP = 0.3
"""A straight line whose neighbouring waypoints differ by more than this in a joint [rad] is no continuous motion."""


GLANCES = 4
"""Starts from which each of many tool poses is tried: of poses within reach they miss one in thirty."""


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

    Every one is within limits and accurate to 1e-5 m and 1e-4 rad, or, of an arm that cannot turn its tool every way,
    to 2e-4 m and 2e-3 rad. None are yielded where the pose is out of reach.

    Args:
        robot: the robot.
        T_world_tool: the wanted tool pose, shape (4, 4).
        rng: shuffles the starts; the same state repeats the same solutions.
        near: a configuration, whose neighbourhood is searched too. Solutions close to it come first; without it, those
            close to the robot's home.
        count: at most so many solutions.
        checker: where given, only configurations it calls free.
    """
    found: list[Array] = []
    most = TRIED * count
    # Branches lie far apart; near home they have one in common, so that ways between tool poses are short.
    middle = robot.home if near is None else near
    for starts, effort in rounds_of_starts(robot, T_world_tool, rng, near, count):
        q, residual = levenberg_marquardt(robot, starts, T_world_tool, effort.patience, enough=count + 2)
        solutions = unwound(robot, q[residual == 0.0], middle)
        solutions = solutions[np.argsort(np.linalg.norm(solutions - middle, axis=1), kind="stable")]
        for q in solutions:
            if any(np.abs(q - other).max() < DISTINCT for other in found):
                continue
            found.append(q)
            if checker is None or checker.free(q):
                yield q
                count -= 1
                if count == 0:
                    return
        if len(found) >= most or (not found and residual.min() > effort.despair):
            return


def turning(robot: RobotModel) -> NDArray[np.bool_]:
    """Which joints turn by more than a whole turn, shape (dof,)."""
    wide: NDArray[np.bool_] = (robot.upper - robot.lower > 2 * math.pi) & ~chain(robot).slides
    return wide


def unwound(robot: RobotModel, q: Array, near: Array) -> Array:
    """Configurations (n, dof) with joints turned by whole turns towards `near`, (dof,), where limits leave room for it.

    A wrist with a range of two turns has two or more positions for each orientation; far ones cost motion for nothing.
    """
    full, wide = 2 * math.pi, turning(robot)
    if not wide.any():
        return q
    nearest = q - full * np.round((q - near) / full)
    nearest = np.where(nearest < robot.lower, nearest + full, np.where(nearest > robot.upper, nearest - full, nearest))
    inside = wide & (nearest >= robot.lower) & (nearest <= robot.upper)
    return np.where(inside, nearest, q)


def reachable(robot: RobotModel, T_world_tools: Array, *, hurried: bool = False) -> NDArray[np.bool_]:
    """Whether a glance finds a configuration within limits for each of many tool poses (n, 4, 4); shape (n,).

    All are solved at once, which takes a sixth of a millisecond a pose where `inverse` may take thirty to give one up.
    In a hurry it ends when half of all starts have got there, and leaves out the poses that take longer.
    """
    if not len(T_world_tools):
        return np.zeros(0, bool)
    starts = nearest_starts(robot, T_world_tools, GLANCES).reshape(-1, robot.dof)
    goals, enough = np.repeat(T_world_tools, GLANCES, axis=0), len(starts) // 2 if hurried else None
    _, residual = levenberg_marquardt(robot, starts, goals, patience=4, enough=enough)
    found: NDArray[np.bool_] = (residual.reshape(-1, GLANCES) == 0.0).any(axis=1)
    return found


def approachable(robot: RobotModel, T_world_tools: Array, back: float) -> NDArray[np.bool_]:
    """Whether a glance finds configurations for each of many tool poses (n, 4, 4), and so far behind it [m]; (n,)."""
    T = np.array(T_world_tools)
    found = reachable(robot, T)
    T[:, :3, 3] -= back * T[:, :3, 2]
    found[found] = reachable(robot, T[found])
    return found


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
        solved, residual = levenberg_marquardt(robot, starts, block, patience=6)
        if residual.any():
            return None
        path.extend(solved)
    line = np.array(path)
    if np.abs(np.diff(line, axis=0)).max(initial=0.0) > MAX_JOINT_STEP:
        return None
    return line


def straight_lines(robot: RobotModel, q: Array, T_goals: Sequence[Array]) -> Array | None:
    """The path, shape (n, dof), along such lines from one of some tool poses (4, 4) to the next; None as for one."""
    path = q[None]
    for T in T_goals:
        line = straight_line(robot, path[-1], T)
        if line is None:
            return None
        path = np.concatenate([path, line[1:]])
    return path


def _interpolated(T_start: Array, T_goal: Array, step: float) -> Array:
    """Poses from start (excluded) to goal along a straight line, shape (n, 4, 4), the tool turning evenly."""
    turn = rotation_vector((T_goal[:3, :3] @ T_start[:3, :3].T)[None])[0]
    angle = float(np.linalg.norm(turn))
    length = float(np.linalg.norm(T_goal[:3, 3] - T_start[:3, 3]))
    count = max(1, math.ceil(length / step - 1e-9), math.ceil(angle / 0.1))
    axis = turn / angle if angle > 1e-12 else np.array([0.0, 0.0, 1.0])
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    share = np.arange(1, count + 1)[:, None, None] / count
    poses = np.tile(np.eye(4), (count, 1, 1))
    partial = np.eye(3) + np.sin(share * angle) * skew + (1 - np.cos(share * angle)) * (skew @ skew)
    poses[:, :3, :3] = partial @ T_start[:3, :3]
    poses[:, :3, 3] = (1 - share[:, 0]) * T_start[:3, 3] + share[:, 0] * T_goal[:3, 3]
    return poses
