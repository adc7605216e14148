"""Inverse kinematics of the Panda: how many reachable poses are found, how exactly, and at what cost.

"reachable": tool poses of uniformly random configurations, so that each has a solution within the limits.
"top-down": the tool pointing down over the table among ten boxes, any yaw; only collision-free solutions count.
"straight up": the tool lifted straight by 8 cm from solutions of the poses before.
Errors are measured by Pinocchio's forward kinematics, which the solver does not use.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.parts.harness import Row, main, percentile
from tamp.task import Box, Table, load_robot
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.robot.model import RobotModel, robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

Array = NDArray[np.float64]

COUNT = 8


def run(quick: bool) -> Iterator[Row]:
    robot = robot_model(load_robot("panda"))
    rng = np.random.default_rng(0)
    next(inverse(robot, robot.forward(robot.home), rng))  # builds the table of starts, once a process
    reachable = [robot.forward(rng.uniform(robot.lower, robot.upper)) for _ in range(500 if quick else 10000)]
    yield _solve("reachable", robot, reachable, None)[0]
    down = [_top_down(rng) for _ in range(300 if quick else 2000)]
    row, solutions = _solve("top-down, collision-free", robot, down, _world(robot))
    yield row
    yield _lift(robot, solutions)


def _solve(
    name: str, robot: RobotModel, poses: list[Array], world: tuple[World, Scene] | None
) -> tuple[Row, list[Array]]:
    """One row over all poses, and the first solution of each that has one."""
    rng = np.random.default_rng(1)
    checker = None if world is None else world[0].checker(world[1])
    first, seconds, first_seconds, solutions = [], 0.0, [], 0
    position = angle = 0.0
    within = True
    for T in poses:
        start = time.perf_counter()
        search = inverse(robot, T, rng, count=COUNT, checker=checker)
        found = [q for q in [next(search, None)] if q is not None]
        first_seconds.append(time.perf_counter() - start)
        found += list(search)
        seconds += time.perf_counter() - start
        solutions += len(found)
        first += found[:1]
        for q in found:
            distance, turn = _errors(robot.forward(q), T)
            position, angle = max(position, distance), max(angle, turn)
            within = within and robot.within_limits(q, slack=0.0)
    row = {
        "poses": name,
        "count": len(poses),
        "found_%": 100 * len(first) / len(poses),
        "solutions": solutions,
        "ms_a_solution": seconds / solutions * 1e3,
        "ms_to_first": percentile(first_seconds, 50) * 1e3,
        "worst_m": position,
        "worst_rad": angle,
        "within_limits": within,
    }
    return row, first


def _lift(robot: RobotModel, starts: list[Array]) -> Row:
    seconds, drawn = 0.0, 0
    for q in starts:
        T = robot.forward(q)
        T[2, 3] += 0.08
        start = time.perf_counter()
        drawn += straight_line(robot, q, T) is not None
        seconds += time.perf_counter() - start
    return {
        "poses": "straight up 8 cm",
        "count": len(starts),
        "found_%": 100 * drawn / len(starts),
        "ms_a_solution": seconds / max(drawn, 1) * 1e3,
    }


def _errors(T: Array, wanted: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses."""
    R = T[:3, :3].T @ wanted[:3, :3]
    skew = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return float(np.linalg.norm(T[:3, 3] - wanted[:3, 3])), float(
        np.arctan2(np.linalg.norm(skew), (np.trace(R) - 1) / 2)
    )


def _top_down(rng: np.random.Generator) -> Array:
    yaw = rng.uniform(-np.pi, np.pi)
    T = np.eye(4)
    T[:3, :3] = [[np.cos(yaw), np.sin(yaw), 0], [np.sin(yaw), -np.cos(yaw), 0], [0, 0, -1]]
    T[:3, 3] = rng.uniform([-0.15, -0.45, 0.03], [0.25, 0.45, 0.2])
    return T


def _world(robot: RobotModel) -> tuple[World, Scene]:
    rng = np.random.default_rng(2)
    poses = {}
    for i in range(10):
        T = np.eye(4)
        T[:3, 3] = (*rng.uniform([-0.15, -0.5], [0.3, 0.5]), 0.04)
        poses[f"box{i}"] = T
    world = World(robot, {name: load_geometry(Box((0.05, 0.05, 0.08))) for name in poses}, Table())
    return world, Scene(poses, opening=robot.spec.gripper.stroke)


if __name__ == "__main__":
    main(
        "kinematics",
        lambda quick: list(run(quick)),
        asked="ms_a_solution top-down at most 1, found_% of reachable at least 99.5, worst_m 1e-5, worst_rad 1e-4",
    )
