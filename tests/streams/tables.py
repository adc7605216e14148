"""Small tables to sample at, and a context to call samplers with."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import At, Box, Mesh, Object, Pose, Region, Task, load_robot
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.robot.model import RobotModel, robot_model
from tamp.world.world import World

OBJECTS = Path(__file__).parents[2] / "scenarios" / "objects"

RED = Object(
    "red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.2, 0.04)), At(Pose((0.05, -0.2, 0.04))), mass=0.1, friction=0.5
)
SLAB = Object("slab", Box((0.14, 0.14, 0.03)), Pose((0.05, -0.05, 0.015)))
CUBE = Object("cube", Box((0.04, 0.04, 0.04)), Pose((-0.15, 0.15, 0.02)))
BRICK = Object("brick", Box((0.3, 0.3, 0.1)), Pose((-0.1, 0.4, 0.05)))
CRATE = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj"), Pose((0.05, 0.0, 0.04)))
CUP = Object("cup", Mesh(OBJECTS / "cup" / "collision.obj"), Pose((0.06, 0.2, 0.05)))


@dataclass
class ToldContext:
    """A sampler's first argument; remembers what it is told."""

    scene: Workspace
    seed: int = 0
    fluents: tuple[Any, ...] = ()
    bound: tuple[Any, ...] = ()
    brief: bool = False
    seconds: float = 60.0
    reasons: list[str] = field(default_factory=list)
    causes: list[tuple[Any, ...]] = field(default_factory=list)
    pauses: int = 0

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        self.deadline = time.monotonic() + self.seconds

    def fail(self, reason: str, because: Any = (), proven: bool = True) -> None:
        self.reasons.append(reason)
        self.causes.append(tuple(because))

    def pause(self) -> None:
        self.pauses += 1


@cache
def panda() -> RobotModel:
    return robot_model(load_robot("panda"))


def workspace_of(
    *objects: Object,
    regions: tuple[Region, ...] = (),
    on: Mapping[str, tuple[str, ...]] | None = None,
    robot: RobotModel | None = None,
) -> Workspace:
    """A workspace where objects stand exactly as they are given, on the table but where `on` says otherwise."""
    task = Task("table", objects, regions=regions)
    world = World(robot or panda(), {o.name: load_geometry(o.shape) for o in objects}, task.table)
    supports = {o.name: (on or {}).get(o.name, (TABLE,)) for o in objects}
    start = {o.name: Placement(o.pose, supports[o.name]) for o in objects}
    goals = {o.name: Placement(o.goal.pose, (TABLE,)) for o in objects if isinstance(o.goal, At)}
    return Workspace(task, world, start, goals)


def at(name: str, placement: Placement) -> tuple[str, str, Placement]:
    return ("AtPose", name, placement)


def corners(workspace: Workspace, name: str, pose: Pose) -> np.ndarray:
    """The vertices of an object's convex parts at a pose, shape (n, 3) [m]."""
    points = np.concatenate([part.vertices for part in workspace.world.geometries[name].parts])
    return points @ pose.matrix[:3, :3].T + pose.matrix[:3, 3]
