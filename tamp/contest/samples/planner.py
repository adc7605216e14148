"""The whole planner as a contestant: looks, estimates poses, plans, carries the plan out, and looks again.

It needs the library `tabletop-tamp[perception]` to be offered. Where a plan reaches only some goals it is carried out
as far; what moved otherwise than planned is seen in the next look.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tamp import clock
from tamp.contest.api.client import Refused
from tamp.errors import PlanningFailure, TampError
from tamp.perception.belief.absence import absent
from tamp.perception.belief.belief import Belief, updated
from tamp.perception.belief.rest import at_rest
from tamp.perception.cameras.camera import Frame, Intrinsics
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.perceiver import load_perceiver
from tamp.perception.rendering.scene import surfaces
from tamp.pipeline.options.settings import settings_of
from tamp.pipeline.plan import Planning
from tamp.pipeline.prepare import prepare
from tamp.task import (
    Action,
    At,
    Fall,
    Goal,
    Grip,
    In,
    Mesh,
    Move,
    Object,
    On,
    Plan,
    Pose,
    Release,
    Table,
    Task,
    load_robot,
)  # fmt: skip
from tamp.task.robot import GENTLE_FORCE
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.world import World

if TYPE_CHECKING:
    from tamp.contest.api.client import Goal as Asked
    from tamp.contest.api.client import GoalObject, Robot
    from tamp.perception.estimate import Estimate

ROUNDS = 4
"""How often it looks and plans at most."""

PLANNING_S = 90.0
"""Processor time for a plan, the same on a busy machine [s]."""

THIN = 0.004
"""Fingers nearer to each other than this, or than half of what they hold is wide, hold nothing [m]."""

GRAVITY = 9.81


class LostError(Exception):
    """The fingers do not hold what they should."""


class Solution:
    """Perceive, plan, act, until every object is where it should be."""

    def run(self, goal: Asked, robot: Robot) -> None:
        """Bring the objects to their goals."""
        known: dict[str, Estimate] = {}
        for seed in range(ROUNDS):
            known = standing(goal, robot, perceived(goal, robot, seed, known))
            task = understood(goal, robot, known)
            try:
                plan = planned(task, robot, seed)
            except (TampError, PlanningFailure) as failure:
                print(f"look {seed}: no plan: {str(failure).splitlines()[0]}")
                continue
            print(f"look {seed}: {len(plan.actions)} actions; left: {dict(plan.report.get('left', {}))}", flush=True)
            if not plan.actions:
                return
            try:
                for action in plan.actions:
                    print(action, flush=True)
                    carry_out(action, robot, task)
                    known = brought(action, known)
            except (LostError, Refused) as problem:
                print(problem, flush=True)
                robot.gripper.go_to(robot.gripper.stroke)
            retreat(robot)


def retreat(robot: Robot) -> None:
    """Up, and home."""
    tool = robot.arm.state().T_world_tool
    tool[2, 3] += 0.1
    try:
        robot.arm.move_pose(tool, speed=0.3)
    except Refused as refused:
        print(f"retreat: {refused}")
    robot.arm.move_joints(robot.arm.home, speed=0.5)


def perceived(goal: Asked, robot: Robot, seed: int, known: dict[str, Estimate]) -> dict[str, Estimate]:
    """Object -> where it is seen to be, from all cameras; the one on the wrist looks from several sides.

    What agrees with what was known keeps its turn, where the shape has symmetries that no picture shows.
    """
    views = {camera.name: camera.viewpoints for camera in load_setup()}
    frames = []
    for name in robot.camera.names:
        for q in views.get(name, ()) or (robot.arm.home,):
            robot.arm.move_joints(q)
            frames.append(as_frame(name, robot))
    robot.arm.move_joints(robot.arm.home)
    looks = surfaces(Task(goal.task, tuple(as_object(thing, Pose()) for thing in goal.objects.values())))
    found = dict(load_perceiver("fit")(frames, looks, table=table_of(goal), seed=seed))
    if not known:
        return found
    poses = {name: estimate.pose for name, estimate in known.items() if estimate.pose is not None}
    models = {name: object_model(look) for name, look in looks.items()}
    return updated(models, known, found, absent(frames, looks, poses, table_of(goal)))


def standing(goal: Asked, robot: Robot, known: dict[str, Estimate]) -> dict[str, Estimate]:
    """Where objects come to rest from where they are seen: no plan begins with two that are a little in each other."""
    task = Task(goal.task, tuple(as_object(thing, Pose()) for thing in goal.objects.values()), table=table_of(goal))
    geometries = {item.name: geometry_of_object(item) for item in task.objects}
    return at_rest(task, World(robot_model(load_robot(robot.name)), geometries, task.table), known)


def brought(action: Action, known: dict[str, Estimate]) -> dict[str, Estimate]:
    """What is known when an action has been carried out: what it released is where it should be, less surely."""
    poses = {step.object: step.pose for step in action.steps if isinstance(step, (Release, Fall))}
    return dict(Belief(known).expecting(poses).estimates)


def as_frame(name: str, robot: Robot) -> Frame:
    """What a camera sees, as perceivers are given it."""
    seen = robot.camera.frame(name)
    height, width = seen.depth.shape
    k = Intrinsics(width, height, *(float(seen.K[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2))))
    return Frame(name, k, seen.T_world_camera, seen.color, seen.depth, seen.robot)


def table_of(goal: Asked) -> Table:
    """The table."""
    x, y, width, depth, thickness = goal.table
    return Table((x, y), (width, depth), thickness)


def as_object(thing: GoalObject, pose: Pose) -> Object:
    """An object at a pose, with its goal."""
    wanted: Goal | None = None
    if thing.pose is not None:
        wanted = At(Pose.from_matrix(thing.pose))
    elif thing.on is not None:
        wanted = On(thing.on)
    elif thing.inside is not None:
        wanted = In(thing.inside)
    return Object(thing.name, Mesh(thing.mesh), pose, wanted, thing.mass, thing.friction)


def understood(goal: Asked, robot: Robot, estimates: dict[str, Estimate]) -> Task:
    """The task as it looks: objects that are not seen are left out."""
    seen = [
        as_object(thing, pose) for name, thing in goal.objects.items() if (pose := estimates[name].pose) is not None
    ]
    return Task(goal.task, tuple(seen), robot.name, table=table_of(goal))


def planned(task: Task, robot: Robot, seed: int) -> Plan:
    """A plan for as many goals as possible, from where the arm is."""
    q = tuple(float(value) for value in robot.arm.state().q)
    with clock.limits_in("processor"):
        deadline = clock.now() + PLANNING_S
        setup = prepare(task, deadline, settings_of({}))
        found = Planning(setup, setup.start, q, seed=seed, deadline=deadline, settings=setup.settings).run()
    if found is None:
        raise PlanningFailure("failed", "nothing can be brought nearer to its goal")
    return found


def carry_out(action: Action, robot: Robot, task: Task) -> None:
    """Do an action step by step."""
    gripper, gentle, firm = load_robot(task.robot).gripper, GENTLE_FORCE, GENTLE_FORCE
    for step in action.steps:
        if isinstance(step, Move):
            if step.held is None:
                robot.gripper.go_to(step.opening)
            path = step.trajectory
            robot.arm.follow(path.times, path.positions, path.velocities)
            if step.held is not None and robot.arm.state().width < least(step.opening):
                raise LostError(f"{step.held.object} is lost")
        elif isinstance(step, Grip):
            item = task.object(step.attachment.object)
            gentle, firm = gripper.pressing(GRAVITY * item.mass, item.friction, step.force)
            robot.gripper.go_to(0.0, gentle)
            if firm > gentle:
                robot.gripper.go_to(0.0, firm)
            if robot.arm.state().width < least(step.width):
                raise LostError(f"{item.name} is not between the fingers")
        elif isinstance(step, Release):
            if firm > gentle:
                robot.gripper.go_to(0.0, gentle)
            robot.gripper.go_to(step.opening)
            robot.wait(0.15)
        elif isinstance(step, Fall):
            robot.wait(1.0)


def least(width: float) -> float:
    """Fingers nearer to each other than this do not hold what is `width` wide between them [m]."""
    return min(THIN, width / 2)
