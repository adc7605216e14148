"""MotionBenchMaker's 700 problems for the Panda (Chamzas et al., 2022), two seconds each, every path rechecked.

A problem counts as valid where its start and its goal are free at MARGIN in our model of the robot. The data is read
from ../shared/motionbenchmaker/panda.tar.bz2 beside the checkout.
"""

from __future__ import annotations

import sys
import tarfile
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from benchmarks.parts.harness import Row, main, percentile
from benchmarks.parts.recheck import Judge, traced
from tamp.task import Box, Cylinder, Object, Pose, RobotSpec, Shape, Sphere, Table, Task, load_robot
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.motion.planner import MotionResult, plan_motion
from tamp.world.robot.model import robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

Array = NDArray[np.float64]

ARCHIVE = Path(__file__).parents[2] / "shared" / "motionbenchmaker" / "panda.tar.bz2"
MARGIN = 0.001
TIMEOUT = 2.0
FAR = Table(center=(100.0, 100.0))  # these scenes bring their own tables


@dataclass(frozen=True, eq=False)
class Problem:
    """A scene, where the arm starts and where it should go; metres and radians, the robot's base at the origin."""

    family: str
    number: int
    objects: tuple[Object, ...]
    start: Array
    goal: Array
    opening: float


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of a problem; `rejected` is the recheck's objection to the path, or None."""

    problem: Problem
    result: MotionResult
    valid: bool
    rejected: str | None


def run(quick: bool) -> Iterator[Row]:
    if not ARCHIVE.is_file():
        raise SystemExit(f"{ARCHIVE} is missing: this benchmark needs MotionBenchMaker's problems there")
    spec = replace(load_robot("panda"), T_world_base=Pose())
    families: dict[str, list[Outcome]] = defaultdict(list)
    for problem in problems(spec, every=14 if quick else 1):
        families[problem.family].append(_outcome(problem, spec))
    for family, outcomes in [*families.items(), ("all", [o for group in families.values() for o in group])]:
        yield _row(family, outcomes)


def problems(spec: RobotSpec, every: int = 1) -> Iterator[Problem]:
    """The archive's problems by set and number, or every n-th of each set."""
    with tarfile.open(ARCHIVE) as archive:
        texts = {m.name: archive.extractfile(m).read() for m in archive if m.isfile()}  # type: ignore[union-attr]
    for name in sorted(n for n in texts if "/scene" in n):
        number = int(Path(name).stem.removeprefix("scene"))
        if number % every == 0:
            scene, request = (
                yaml.load(texts[n], Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
                for n in (name, name.replace("/scene", "/request"))
            )
            yield _problem(Path(name).parent.name.removesuffix("_panda"), number, scene, request, spec)


def _problem(family: str, number: int, scene: Any, request: Any, spec: RobotSpec) -> Problem:
    objects = []
    for item in scene["world"]["collision_objects"]:
        for primitive, pose in zip(item["primitives"], item["primitive_poses"], strict=True):
            placed = Pose(tuple(pose["position"]), tuple(pose["orientation"]))
            objects.append(Object(f"{item['id']} {len(objects)}", _shape(primitive), placed))
    state = request["start_state"]["joint_state"]
    start = dict(zip(state["name"], state["position"], strict=True))
    goal = {c["joint_name"]: c["position"] for c in request["goal_constraints"][0]["joint_constraints"]}
    opening = sum(start[joint] for joint in spec.gripper.joints)  # as published: wider than the real fingers open
    # MoveIt's own limits are the URDF's: a problem may lie a rounding error beyond the maker's.
    ends = [np.clip([values[j] for j in spec.joints], spec.lower, spec.upper) for values in (start, goal)]
    return Problem(family, number, tuple(objects), *ends, opening)


def _shape(primitive: Any) -> Shape:
    size = [float(v) for v in primitive["dimensions"]]
    if primitive["type"] == "box":
        return Box((size[0], size[1], size[2]))
    if primitive["type"] == "cylinder":
        return Cylinder(radius=size[1], height=size[0])
    if primitive["type"] == "sphere":
        return Sphere(size[0])
    raise ValueError(f"unknown primitive {primitive['type']!r}; expected box, cylinder or sphere")


def _outcome(problem: Problem, spec: RobotSpec) -> Outcome:
    robot = robot_model(spec)
    world = World(robot, {o.name: load_geometry(o.shape) for o in problem.objects}, FAR)
    scene = Scene({o.name: o.pose.matrix for o in problem.objects}, opening=problem.opening)
    checker = world.checker(scene, margin=MARGIN)
    valid = checker.free(problem.start) and checker.free(problem.goal)
    result = plan_motion(
        checker,
        robot.lower,
        robot.upper,
        problem.start,
        problem.goal,
        seed=problem.number,
        timeout=TIMEOUT,
        iterations=10**9,
        recheck=0.01,
    )
    if result.path is None:
        print(f"{problem.family} {problem.number}: {result.reason}", file=sys.stderr)
        return Outcome(problem, result, valid, None)
    judge = Judge(Task(problem.family, problem.objects, table=FAR), opening=problem.opening, robot=spec)
    rejected = judge.touch(traced(result.path))
    if rejected:
        print(f"{problem.family} {problem.number}: rejected: {rejected}", file=sys.stderr)
    return Outcome(problem, result, valid, rejected)


def _row(family: str, outcomes: list[Outcome]) -> Row:
    valid = [o for o in outcomes if o.valid]
    solved = [o for o in valid if o.result.path is not None]
    times = [1e3 * (o.result.planning_s + o.result.simplify_s) for o in valid] or [0.0]
    return {
        "set": family,
        "problems": len(outcomes),
        "valid": len(valid),
        "solved": len(solved),
        "median_ms": percentile(times, 50),
        "p95_ms": percentile(times, 95),
        "slowest_ms": max(times),
        "rejected": sum(o.rejected is not None for o in solved),
    }


if __name__ == "__main__":
    main(
        "motionbenchmaker",
        lambda quick: list(run(quick)),
        asked="every valid problem solved, slowest_ms at most 2000, rejected 0",
    )
