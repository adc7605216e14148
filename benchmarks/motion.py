"""Motion in clutter: the Panda carries a box from one spot on the table to another among 10 and 30 boxes.

Each query starts and ends in a collision-free, top-down configuration over a random spot. A query that the default
planner does not solve is given to every planner for five seconds: only if one of them solves it, it counts as missed.
Every path is rechecked by the checker of plans, which uses python-fcl and its own kinematics.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.parts.harness import Row, main, percentile
from benchmarks.parts.recheck import Judge, traced
from tamp.task import Box, Object, Pose, Task, load_robot
from tamp.world.collision.checker import CollisionChecker
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.kinematics.inverse import inverse
from tamp.world.motion.paths import length
from tamp.world.motion.planner import PORTFOLIO, MotionResult, plan_motion, planner_names
from tamp.world.robot.model import RobotModel, robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

Array = NDArray[np.float64]

OBSTACLE = (0.06, 0.06, 0.16)
HELD = (0.05, 0.05, 0.08)
MARGIN = 0.005


@dataclass(frozen=True, eq=False)
class Clutter:
    """A task whose first objects stand on the table and whose last one, "held", is in the gripper."""

    task: Task
    checker: CollisionChecker
    robot: RobotModel


def run(quick: bool) -> Iterator[Row]:
    for count in (10, 30):
        clutter = make_clutter(count, seed=count)
        queries = pick_to_place(clutter, 20 if quick else 100, np.random.default_rng(count))
        judge = Judge(clutter.task, held="held", opening=HELD[1])
        plan(clutter, queries[0], seed=0)
        results = [plan(clutter, query, seed=i) for i, query in enumerate(queries)]
        solved = [r for r in results if r.path is not None]
        missed = sum(r.path is None and _solvable(clutter, q) for q, r in zip(queries, results, strict=True))
        total = [1e3 * (r.planning_s + r.simplify_s) for r in results]
        yield {
            "obstacles": count,
            "queries": len(queries),
            "solved": len(solved),
            "missed": missed,
            "median_ms": percentile(total, 50),
            "p95_ms": percentile(total, 95),
            "planning_ms": percentile([1e3 * r.planning_s for r in results], 50),
            "simplify_ms": percentile([1e3 * r.simplify_s for r in results], 50),
            "straight": sum(len(r.path) == 2 for r in solved if r.path is not None),
            "length_rad": float(np.mean([length(r.path) for r in solved if r.path is not None])),
            "rejected": sum(judge.touch(traced(r.path)) is not None for r in solved if r.path is not None),
        }


def plan(clutter: Clutter, query: tuple[Array, Array], seed: int, planner: str = PORTFOLIO) -> MotionResult:
    """Answer one query within five seconds."""
    robot = clutter.robot
    return plan_motion(
        clutter.checker, robot.lower, robot.upper, *query, seed=seed, timeout=5.0, planner=planner, iterations=10**9
    )


def _solvable(clutter: Clutter, query: tuple[Array, Array]) -> bool:
    return any(plan(clutter, query, seed=1000, planner=name).path is not None for name in planner_names())


def make_clutter(count: int, seed: int) -> Clutter:
    """Boxes scattered over the table, clear of each other and of the robot's base."""
    rng = np.random.default_rng(seed)
    spots: list[Array] = []
    while len(spots) < count:
        spot = rng.uniform([-0.2, -0.5], [0.25, 0.5])
        if all(np.linalg.norm(spot - other) > 0.1 for other in spots):
            spots.append(spot)
    objects = tuple(
        Object(f"box{i}", Box(OBSTACLE), Pose.from_rpy((x, y, OBSTACLE[2] / 2), (0.0, 0.0, rng.uniform(-3.0, 3.0))))
        for i, (x, y) in enumerate(spots)
    )
    held = Object("held", Box(HELD), Pose((0.0, 0.0, HELD[2] / 2)))
    robot = robot_model(load_robot("panda"))
    world = World(robot, {o.name: load_geometry(o.shape) for o in (*objects, held)})
    scene = Scene({o.name: o.pose.matrix for o in objects}).attached("held", np.eye(4), HELD[1])
    return Clutter(Task("clutter", (*objects, held)), world.checker(scene, margin=MARGIN), robot)


def pick_to_place(clutter: Clutter, count: int, rng: np.random.Generator) -> list[tuple[Array, Array]]:
    """Pairs of free configurations, the tool pointing down at random over spots of the table."""
    ends: list[Array] = []
    while len(ends) < 2 * count:
        x, y = rng.uniform([-0.2, -0.5], [0.25, 0.5])
        T_world_tool = Pose.from_rpy((x, y, rng.uniform(0.06, 0.2)), (np.pi, 0.0, rng.uniform(-np.pi, np.pi))).matrix
        found = next(iter(inverse(clutter.robot, T_world_tool, rng, checker=clutter.checker)), None)
        if found is not None and clutter.checker.free(found):
            ends.append(found)
    return list(zip(ends[::2], ends[1::2], strict=True))


if __name__ == "__main__":
    main(
        "motion",
        lambda quick: list(run(quick)),
        asked="median_ms at most 10 and 15 with 10 and 30 obstacles, p95_ms at most 60, missed 0, rejected 0",
    )
