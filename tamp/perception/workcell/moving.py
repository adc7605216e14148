"""Bringing the arm from where it is to where it looks from, clear of all that is known to stand on the table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.recovery import way_out
from tamp.perception.workcell.workcell import Workcell
from tamp.task import Pose
from tamp.world.motion.planner import plan_motion
from tamp.world.scene import Scene
from tamp.world.timing.time_parametrization import time_path
from tamp.world.world import World

if TYPE_CHECKING:
    from numpy.typing import NDArray

CLEARANCE = 0.01
"""Least distance to what is known while the arm moves to look [m]; less where there is no other way."""

TIGHT = 0.002

ITERATIONS = 4000
"""Of the motion planner, for each way."""

SPEED = 0.6
"""Share of the arm's limits on the way."""

DRAWN_OUT = 0.2
"""Share of its limits at which the arm leaves what it is too near to."""


def go_to(cell: Workcell, world: World, poses: Mapping[str, Pose], q: Sequence[float], *, seed: int) -> bool:
    """Move the empty hand to a configuration.

    Args:
        cell: the workcell.
        world: the planner's picture of robot, table and objects.
        poses: object -> where it is thought to be (world frame).
        q: the configuration [rad].
        seed: of the motion planner.

    Returns:
        Whether the arm is there; where there is no way it stays where it is.
    """
    robot = world.robot
    draw_out(cell, world, poses)
    scene = Scene({name: pose.matrix for name, pose in poses.items()}, opening=robot.spec.gripper.stroke)
    goal = np.array(q, dtype=np.float64)
    for margin in (CLEARANCE, TIGHT):
        checker = world.checker(scene, margin=margin)
        start = _now(cell, world)
        found = plan_motion(
            checker, robot.lower, robot.upper, start, goal, seed=seed, timeout=60.0, iterations=ITERATIONS
        )
        if found.path is not None:
            cell.follow(time_path(found.path, robot.spec, speed=SPEED))
            return True
    return False


def draw_out(cell: Workcell, world: World, poses: Mapping[str, Pose]) -> None:
    """Move the empty hand away from what it is too near to, where there is a way."""
    out = way_out(world, poses, _now(cell, world))
    if out is not None:
        cell.follow(time_path(out, world.robot.spec, speed=DRAWN_OUT))


def _now(cell: Workcell, world: World) -> NDArray[np.float64]:
    return np.asarray(np.clip(np.array(cell.configuration()), world.robot.lower, world.robot.upper))
