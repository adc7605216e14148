"""What is loaded and compiled before any limit runs: samplers, the models they learned, and loops over small arrays."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np

from tamp.checking import check
from tamp.checking.robot.links import read_links
from tamp.domains.learned import load_models
from tamp.domains.samplers import resolve_samplers
from tamp.execution.simulators import DEFAULT, load_simulator
from tamp.pipeline.options.settings import DEFAULT_SETTINGS, Settings
from tamp.pipeline.prepare import domain_of
from tamp.planning import Context
from tamp.streams.affordances.stable_poses import outline
from tamp.streams.affordances.tilts import tilts
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Action, Box, Move, Object, Plan, Pose, Task, task_robot
from tamp.threads import one_thread
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.timing.time_parametrization import time_path
from tamp.world.world import World


def load_samplers(task: Task, settings: Settings) -> None:
    """Import whatever serves the streams and let it read its models; called before any limit runs.

    Raises:
        DomainError, RobotError, SamplerError, TaskError: where domain, robot, functions or models cannot be had.
    """
    domain = domain_of(task, settings.domain)
    _ = domain.rules  # whatever is wrong with them is said now, not by the checker of a plan
    load_models(resolve_samplers(domain.samplers, task.samplers, settings.samplers).values())
    with one_thread():
        warm_up(Task("nothing", (), robot=task.robot, path=task.path, base=task.base, home=task.home))


def preload(nothing: Task) -> None:
    """Load what every run of a robot needs and no object decides: compiled loops, the robot's tables, physics engine.

    No thread is started by it, no simulation opened, and no generator of a run's used: a process forked afterwards
    computes what a fresh one would, sooner.

    Args:
        nothing: a task without objects, for the robot.

    Raises:
        TampError: where something cannot be had.
    """
    import tamp.world.motion.ompl
    import tamp.world.timing.path_rates  # noqa: F401  # both are slow to load, and wait elsewhere until they are needed

    with one_thread():
        load_samplers(nothing, DEFAULT_SETTINGS)
        read_links(task_robot(nothing))
    load_simulator(DEFAULT)


@cache
def warm_up(nothing: Task) -> None:
    """Have the compiled loops ready: a cube is asked about on an empty table, and a motion beside it timed and checked.

    Those that no process has called before are compiled here, for half a minute, and the others read from disk.

    Args:
        nothing: a task without objects, for the robot.
    """
    robot, cube = robot_model(task_robot(nothing)), Object("cube", Box((0.04, 0.04, 0.04)), Pose((0.0, 0.0, 0.02)))
    task, place = replace(nothing, objects=(cube,)), Placement(cube.pose, (TABLE,))
    workspace = Workspace(task, World(robot, {"cube": geometry_of_object(cube)}, task.table), {"cube": place}, {})
    context = Context(workspace, lambda: np.random.default_rng(0), math.inf)
    outline(np.eye(3, 2))
    tilts(workspace, "cube", place)
    for grasp in islice(sample_grasp(context, "cube"), 1):
        next(inverse_kinematics(context, "cube", place, grasp), None)
    home = np.array(robot.spec.home)
    bent = home + np.linspace(0.0, 0.1, len(home))
    motion = Move("transit", time_path(np.array([home, bent, bent - 0.05]), robot.spec), robot.spec.gripper.stroke)
    check(
        task, Plan(task.name, task.robot, 0, {"cube": cube.pose}, robot.spec.home, {}, (Action("move", (), (motion,)),))
    )
