"""Carrying out a plan in the simulator, watching it, and stopping where a new plan is needed.

The gripper holds by friction alone: nothing is ever welded, moved by hand or put back.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property

import numpy as np

from tamp.errors import PlanError
from tamp.execution.action_execution import Performer
from tamp.execution.controller import Operator
from tamp.execution.log import ActionLog, Deviation, Execution, Frame, Status
from tamp.execution.monitor import Monitor, deviation, is_off
from tamp.execution.recovery import can_carry, met_ahead, opening_out, way_out
from tamp.execution.simulator import STEP, Simulator
from tamp.execution.simulators import DEFAULT, make_simulator
from tamp.task import Action, Attachment, Grip, Move, Plan, Pose, Step, Task, task_robot
from tamp.world.geometry.object_geometry import geometry_of_object
from tamp.world.robot.model import robot_model
from tamp.world.timing.time_parametrization import time_path
from tamp.world.world import World

START_TOLERANCE = 0.05
"""How far the arm may stand from where a plan starts [rad]."""

SETTLE_S = 1.0
"""How long the scene settles at the end [s]."""

DRAWN_OUT = 0.2
"""Share of its limits at which the arm leaves what it touches."""

FOLLOWED = 6
"""How often it does so at most, where what leans on the hand comes after it."""

WATCHFUL = Monitor()


class Executor:
    """A running execution: one simulated world that several plans may be carried out in, one after the other.

    Between plans the hand is empty and out of what a fault made it touch, and the scene is at rest, so that `poses()`
    and `configuration()` are what a new plan may start from.
    """

    def __init__(self, task: Task, simulator: Simulator, monitor: Monitor | None, frame_s: float | None = None) -> None:
        self._task = task
        self._simulator = simulator
        self._monitor = monitor
        self._operator = Operator(simulator)
        self._performer = Performer(simulator, self._operator, monitor, self._can_carry)
        self._frames: list[Frame] = []
        if frame_s is not None:
            self._record(max(1, round(frame_s / STEP)))

    @property
    def time(self) -> float:
        """Simulated time since the world was built [s]."""
        return self._simulator.time

    def poses(self) -> dict[str, Pose]:
        """Object -> where it stands now (world frame)."""
        return self._simulator.poses()

    def configuration(self) -> tuple[float, ...]:
        """Where the arm's joints are now [rad]."""
        return tuple(float(q) for q in self._operator.robot.configuration())

    def frame(self) -> Frame:
        """The scene as it is now."""
        return Frame(self.time, self.poses(), self.configuration(), self._operator.robot.opening())

    def _record(self, every: int) -> None:
        """Keep a frame now and then every so many steps."""
        steps = itertools.count(1)
        self._frames.append(self.frame())

        def keep() -> None:
            if next(steps) % every == 0:
                self._frames.append(self.frame())

        self._simulator.on_step = keep

    def carry_out(self, plan: Plan, *, settle: bool = True) -> Execution:
        """Run a plan to its end, or until something is off by more than the monitor tolerates.

        A disturbed object stops the plan once the hand is empty: what is held is put down first. An object that the
        fingers missed or lost stops it at once, and so does one that turned between them as it was lifted and would
        now meet others on its way: it is put back. Nor does the empty hand set out on a way on which it would meet what
        lies a little otherwise than planned. After a stop the hand is drawn out of what it touches.

        Args:
            plan: from where the arm stands.
            settle: whether the scene settles at the end where nothing was off, too.

        Raises:
            PlanError: where the plan is for other objects or joints, or starts from another arm configuration.
        """
        self._refuse_misfit(plan)
        began, first_frame = self._simulator.time, len(self._frames)
        expected = dict(plan.start)
        log: list[ActionLog] = []
        stop: Deviation | None = None
        status: Status = "done"
        for index, action in enumerate(plan.actions):
            after = [step for later in plan.actions[index + 1 :] for step in later.steps]
            if (stop := self._met_ahead(action, expected)) is not None:
                status = "deviated"
                break
            entry, lost = self._performer.perform(action, expected, after)
            log.append(entry)
            if lost is not None or (entry.deviations and self._operator.held is None):
                stop, status = lost or entry.deviations[0], "deviated"
                break
            if self._simulator.time > self._task.limits.execution_sim_s:
                status = "timeout"
                break
        if settle or status == "deviated":
            self._simulator.step(round(SETTLE_S / STEP))
        if status == "deviated":
            self._draw_out()
        return Execution(
            status=status,
            final_poses=self.poses(),
            configuration=self.configuration(),
            log=tuple(log),
            sim_s=self._simulator.time - began,
            deviation=stop,
            frames=tuple(self._frames[first_frame:]),
        )

    def _refuse_misfit(self, plan: Plan) -> None:
        q = self._operator.robot.configuration()
        refuse_misfit(plan, self._simulator.objects, len(q))
        off = np.abs(np.array(plan.home) - q).max()
        if off > START_TOLERANCE:
            raise PlanError(f"the plan starts {off:.3f} rad from where the arm stands; {START_TOLERANCE} is tolerated")

    def _can_carry(self, held: Attachment, steps: Sequence[Step]) -> bool:
        """Whether what is held meets nothing on its way, as it lies in the hand now."""
        return can_carry(self._world, self.poses(), held, steps)

    def _met_ahead(self, action: Action, expected: Mapping[str, Pose]) -> Deviation | None:
        """How far what the empty hand would meet on its way is off; None where it meets nothing, or nobody watches."""
        step = next(iter(action.steps), None)
        if self._monitor is None or not isinstance(step, Move) or step.phase != "transit":
            return None
        poses = self.poses()
        shifted = [
            off for name, pose in expected.items() if is_off(off := deviation(name, "misplaced", pose, poses[name]))
        ]
        met = met_ahead(self._world, {off.object: poses[off.object] for off in shifted}, step) if shifted else None
        return next((off for off in shifted if off.object == met), None)

    def _draw_out(self) -> None:
        """Move the empty hand away from what it is too near to plan from, until nothing leans on it any more."""
        robot = self._operator.robot
        for tried in range(FOLLOWED):
            poses, q = self.poses(), robot.configuration()
            path = way_out(self._world, poses, q, tried)
            if path is None:
                return
            opening = opening_out(self._world, poses, q, max(0.0, robot.opening()))
            self._operator.move(Move("retreat", time_path(path, robot.spec, speed=DRAWN_OUT), opening))
            self._simulator.step(round(SETTLE_S / STEP))

    @cached_property
    def _world(self) -> World:
        """The planner's picture of the scene; made only where something is not as planned."""
        geometries = {obj.name: geometry_of_object(obj) for obj in self._task.objects}
        return World(robot_model(self._operator.robot.spec), geometries, self._task.table)


def refuse_misfit(plan: Plan, objects: Collection[str], joints: int) -> None:
    """Refuse a plan that nobody can follow, whatever comes of it.

    Args:
        plan: from wherever.
        objects: names of those in the scene.
        joints: how many the arm has.

    Raises:
        PlanError: where it is about other objects, for another arm, or has motions at times that do not increase.
    """
    for name in (*plan.start, *filter(None, map(_handled, plan.steps))):
        if name not in objects:
            raise PlanError(f"the plan is about {name!r}; the scene has {', '.join(sorted(objects))}")
    if len(plan.home) != joints:
        raise PlanError(f"the plan's home has {len(plan.home)} values; the arm has {joints} joints")
    for move in (step for step in plan.steps if isinstance(step, Move)):
        times, positions = move.trajectory.times, move.trajectory.positions
        if not len(times) or positions.shape[1:] != (joints,) or (np.diff(times) <= 0.0).any():
            raise PlanError(f"a {move.phase} motion is none of {joints} joints at times that increase")


def _handled(step: Step) -> str | None:
    """The object that a step handles, or None."""
    if isinstance(step, Move):
        return None if step.pushed is None else step.pushed.object
    return step.attachment.object if isinstance(step, Grip) else step.object


@contextmanager
def open_execution(
    task: Task,
    start: Mapping[str, Pose],
    q: Sequence[float] | None = None,
    *,
    seed: int = 0,
    jitter: float = 0.0,
    monitor: Monitor | None = WATCHFUL,
    frame_s: float | None = None,
    simulator: str = DEFAULT,
) -> Iterator[Executor]:
    """A simulated world to carry out plans in.

    Args:
        task: objects, table and robot.
        start: object -> pose (world frame) it starts from; normally a settled scene.
        q: arm configuration to start from [rad]; the robot's home where it is None.
        seed: decides the jitter; without jitter the simulation knows no chance.
        jitter: standard deviation of a random shift of each object on the table [m], unknown to the plan.
        monitor: when to give up a plan; None never does.
        frame_s: simulated time between recorded frames [s]; None records none.
        simulator: its name, or "package.module:Class".

    Raises:
        PlanError: where the arm has more joints than it is to start from, or fewer.
        TaskError: where an object's mesh cannot be used.
        RobotError: where the robot's URDF cannot be used.
        TampError: where the simulator is unknown or not installed.
    """
    rng = np.random.default_rng(seed)
    shifted = {name: Pose((*rng.normal(0.0, jitter, 2), 0.0)) for name in sorted(start)} if jitter > 0 else {}
    poses = {
        name: Pose(tuple(np.add(pose.xyz, shifted[name].xyz)), pose.quat) if name in shifted else pose
        for name, pose in start.items()
    }
    spec = task_robot(task)
    if q is not None and len(q) != len(spec.joints):
        joints = len(spec.joints)
        raise PlanError(f"the arm is to start from {len(q)} joint positions; robot {spec.name!r} has {joints}")
    with make_simulator(simulator, task.objects, poses, table=task.table, robot=spec, q=q) as world:
        yield Executor(task, world, monitor, frame_s)


def execute(
    task: Task,
    plan: Plan,
    *,
    seed: int = 0,
    jitter: float = 0.0,
    monitor: Monitor | None = WATCHFUL,
    frame_s: float | None = None,
    simulator: str = DEFAULT,
    settle: bool = True,
) -> Execution:
    """Carry out a plan from its own start in a world of its own; see `open_execution` and `Executor.carry_out`."""
    with open_execution(
        task,
        plan.start,
        plan.home,
        seed=seed,
        jitter=jitter,
        monitor=monitor,
        frame_s=frame_s,
        simulator=simulator,
    ) as run:
        return run.carry_out(plan, settle=settle)
