"""A task made ready: its geometry read, what cannot be refused, start and goals settled."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from tamp.execution.settling import settle
from tamp.pipeline.situation import settled_goals
from tamp.pipeline.validity import check_geometry, check_settled
from tamp.streams.values import Placement
from tamp.task import Pose, Task, load_robot
from tamp.task.validate import validate
from tamp.world.geometry import load_geometry
from tamp.world.robot_model import robot_model
from tamp.world.world import World


@dataclass(frozen=True, eq=False)
class Setup:
    """A task ready to be planned: geometry, the settled start, and what the goals mean.

    Attributes:
        task: the task.
        world: its geometry and robot.
        start: object -> pose (world frame) after settling.
        goals: object with a goal pose -> the placement it comes to rest in.
    """

    task: Task
    world: World
    start: Mapping[str, Pose]
    goals: Mapping[str, Placement]


def prepare(task: Task, deadline: float = math.inf) -> Setup:
    """Read the geometry, refuse what cannot be, and let start and goals settle.

    Args:
        task: the task.
        deadline: on the clock of time.monotonic [s].

    Raises:
        PlanningFailure: where that has not ended by the deadline.
        TaskError: where the task cannot be used; one sentence that says where and why.
        RobotError: where its robot cannot.
    """
    validate(task)
    world = World(
        robot_model(load_robot(task.robot)), {obj.name: load_geometry(obj.shape) for obj in task.objects}, task.table
    )
    check_geometry(task, world)
    start = settle(task, deadline=deadline).poses
    goals = settled_goals(task, world, start, deadline)
    check_settled(task, start, goals)
    return Setup(task, world, start, goals)
