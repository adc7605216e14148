"""Carrying out a plan in the simulator, watching it, and stopping where a new plan is needed.

The gripper holds by friction alone: nothing is ever welded, moved by hand or put back.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np

from tamp.errors import PlanError
from tamp.execution.monitor import Monitor
from tamp.execution.operator import Operator
from tamp.execution.record import ActionLog, Deviation, Execution, Frame, Status
from tamp.execution.simulator import STEP, Simulator
from tamp.task import Action, Fall, Grip, Move, Plan, Pose, Release, Task, load_robot

START_TOLERANCE = 0.05
"""How far the arm may stand from where a plan starts [rad]."""

SETTLE_S = 1.0
"""How long the scene settles at the end [s]."""

WATCHFUL = Monitor()


class Executor:
    """A running execution: one simulated world that several plans may be carried out in, one after the other.

    Between plans the hand is empty and the scene at rest, so that `poses()` and `configuration()` are what a new plan
    may start from.
    """

    def __init__(self, task: Task, simulator: Simulator, monitor: Monitor | None, frame_s: float | None = None) -> None:
        self._task = task
        self._simulator = simulator
        self._operator = Operator(simulator)
        self._monitor = monitor
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

    def carry_out(self, plan: Plan) -> Execution:
        """Run a plan to its end, or until something is off by more than the monitor tolerates.

        A disturbed object stops the plan once the hand is empty: what is held is put down first. An object that the
        fingers missed or lost stops it at once.

        Raises:
            PlanError: where the plan is for other objects, or starts from another arm configuration.
        """
        self._refuse_misfit(plan)
        began, first_frame = self._simulator.time, len(self._frames)
        expected = dict(plan.start)
        log: list[ActionLog] = []
        stop: Deviation | None = None
        status: Status = "done"
        for action in plan.actions:
            entry, lost = self._carry_out_action(action, expected)
            log.append(entry)
            if lost is not None or (entry.deviations and self._operator.held is None):
                stop, status = lost or entry.deviations[0], "deviated"
                break
            if self._simulator.time > self._task.limits.execution_sim_s:
                status = "timeout"
                break
        self._simulator.step(round(SETTLE_S / STEP))
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
        known = self._simulator.bodies
        for name in plan.start:
            if name not in known:
                raise PlanError(f"the plan is about {name!r}; the scene has {', '.join(sorted(known))}")
        off = np.abs(np.array(plan.home) - self._operator.robot.configuration()).max()
        if off > START_TOLERANCE:
            raise PlanError(f"the plan starts {off:.3f} rad from where the arm stands; {START_TOLERANCE} is tolerated")

    def _carry_out_action(self, action: Action, expected: dict[str, Pose]) -> tuple[ActionLog, Deviation | None]:
        """One action; updates `expected`. The second result is a grasp that failed."""
        began = self._simulator.time
        self._operator.tracking_error = 0.0
        attempted = succeeded = 0
        proven = self._operator.held is not None
        lost: Deviation | None = None
        placed = []
        for step in action.steps:
            if lost is not None and not (isinstance(step, Move) and step.phase == "lift"):
                continue  # with nothing in the hand, what is left to do is to draw back
            if isinstance(step, Grip):
                attempted += 1
                expected.pop(step.attachment.object, None)
                lost = self._operator.grip(step)
            elif isinstance(step, Release):
                self._operator.release(step)
                expected[step.object] = step.pose
                placed.append(step.object)
            elif isinstance(step, Fall):
                self._operator.await_fall(step.object)
                expected[step.object] = step.pose
            else:
                self._operator.move(step)
                lost = lost or self._operator.lost()
                if self._operator.held is not None and not proven:
                    succeeded, proven = succeeded + 1, True
        poses = self.poses()
        deviations = (*self._held_deviation(), *self._compare(expected, poses, placed))
        elapsed = self._simulator.time - began
        return (
            ActionLog(str(action), elapsed, attempted, succeeded, poses, deviations, self._operator.tracking_error),
            lost if self._monitor is not None else None,
        )

    def _held_deviation(self) -> tuple[Deviation, ...]:
        held = self._operator.held
        if held is None or self._monitor is None:
            return ()
        slipped = self._monitor.slipped(held.object, held.T_tool_object, self._operator.in_tool(held.object))
        return () if slipped is None else (slipped,)

    def _compare(
        self, expected: Mapping[str, Pose], poses: Mapping[str, Pose], placed: Sequence[str]
    ) -> tuple[Deviation, ...]:
        return () if self._monitor is None else self._monitor.compare(expected, poses, placed)


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

    Raises:
        TaskError: where an object's mesh cannot be used.
        RobotError: where the robot's URDF cannot be used.
    """
    rng = np.random.default_rng(seed)
    shifted = {name: Pose((*rng.normal(0.0, jitter, 2), 0.0)) for name in sorted(start)} if jitter > 0 else {}
    poses = {
        name: Pose(tuple(np.add(pose.xyz, shifted[name].xyz)), pose.quat) if name in shifted else pose
        for name, pose in start.items()
    }
    with Simulator(task.objects, poses, table=task.table, robot=load_robot(task.robot), q=q) as simulator:
        yield Executor(task, simulator, monitor, frame_s)


def execute(
    task: Task,
    plan: Plan,
    *,
    seed: int = 0,
    jitter: float = 0.0,
    monitor: Monitor | None = WATCHFUL,
    frame_s: float | None = None,
) -> Execution:
    """Carry out a plan from its own start in a world of its own; see `open_execution` and `Executor.carry_out`."""
    with open_execution(task, plan.start, plan.home, seed=seed, jitter=jitter, monitor=monitor, frame_s=frame_s) as run:
        return run.carry_out(plan)
