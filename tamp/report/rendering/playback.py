"""A run as it went, moment by moment: its plans played kinematically, or carried out in the simulator once more."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.errors import TampError
from tamp.execution.executor import open_execution, refuse_misfit
from tamp.execution.log import Execution, Frame
from tamp.execution.simulators import DEFAULT
from tamp.report.runs import Recorded
from tamp.task import Action, Fall, Grip, Move, Plan, Pose, Release, Task, task_robot
from tamp.world.robot.model import RobotModel, robot_model
from tamp.world.timing.trajectory import positions_at

if TYPE_CHECKING:
    from numpy.typing import NDArray

END_S = 1.0
"""How long the end is shown [s]."""
MOST = 100_000
"""Moments that are played."""


@dataclass(frozen=True)
class Moment:
    """The scene at one time, and the action that is under way."""

    frame: Frame
    action: str


def play(run: Recorded, frame_s: float) -> tuple[Moment, ...]:
    """The run's plans one after the other, as they were meant, and where everything was at the end.

    Args:
        run: a recorded run.
        frame_s: time between moments [s].

    Raises:
        TampError: where the run has no plan, or its task's file is gone.
    """
    task = playable(run)
    if (moments := sum(plan.duration for plan in run.plans) / frame_s) > MOST:
        raise TampError(f"{run.folder}: {moments:,.0f} moments are more than {MOST:,}: ask for fewer a second")
    played = list(_plans(task, run.plans, frame_s))
    last = played[-1].frame
    poses = {name: run.final_poses.get(name, pose) for name, pose in last.poses.items()}
    end = Frame(last.time + END_S, poses, last.configuration, last.opening)
    return (*played, Moment(end, run.result.status))


def simulate(run: Recorded, frame_s: float, simulator: str | None = None) -> tuple[Moment, ...]:
    """The same plans carried out once more, as `play` gives them; in the run's simulator where none is named."""
    task = playable(run)
    first = run.plans[0]
    moments: list[Moment] = []
    seed = run.result.seed
    where = simulator or run.result.simulator or DEFAULT
    with open_execution(task, first.start, first.home, seed=seed, frame_s=frame_s, simulator=where) as executor:
        for plan in run.plans:
            moments += _labelled(executor.carry_out(plan))
    return tuple(moments)


def playable(run: Recorded) -> Task:
    """The task of a run that has a plan.

    Raises:
        TampError: where there is nothing to play, or it is not for the run's task.
    """
    if run.task is None:
        raise TampError(f"{run.folder}: its task {run.result.task_path or '(built in code)'} cannot be read")
    if not run.plans:
        raise TampError(f"{run.folder}: it has no plan to play ({run.result.status})")
    names = {thing.name for thing in run.task.objects}
    for plan in run.plans:
        refuse_misfit(plan, names, len(task_robot(run.task).joints))
        if missing := names - plan.start.keys():
            raise TampError(f"{run.folder}: its plan does not say where {', '.join(sorted(missing))} starts")
    return run.task


def _labelled(execution: Execution) -> Iterator[Moment]:
    """Frames with the actions that were under way, told by how long each took."""
    if not execution.frames:
        return
    ends = execution.frames[0].time + np.cumsum([entry.sim_s for entry in execution.log])
    for frame in execution.frames:
        place = min(int(np.searchsorted(ends, frame.time)), len(ends) - 1)
        yield Moment(frame, execution.log[place].name)


def _plans(task: Task, plans: Sequence[Plan], frame_s: float) -> Iterator[Moment]:
    robot = robot_model(task_robot(task))
    time = 0.0
    for plan in plans:
        yield Moment(Frame(time, plan.start, plan.home, robot.spec.gripper.stroke), "start")
        stage = _Stage(robot, dict(plan.start), plan.home)
        for action in plan.actions:
            for frame in stage.act(action, time, frame_s):
                yield Moment(frame, str(action))
                time = frame.time


class _Stage:
    """Where everything is while a plan is played."""

    def __init__(self, robot: RobotModel, poses: dict[str, Pose], q: tuple[float, ...]) -> None:
        self._robot, self._poses, self._q = robot, poses, q
        self._opening = robot.spec.gripper.stroke

    def act(self, action: Action, time: float, frame_s: float) -> Iterator[Frame]:
        """The frames of an action that begins at `time` [s]; what is no motion takes one frame."""
        for step in action.steps:
            match step:
                case Move():
                    count = max(1, round(step.trajectory.duration / frame_s))
                    self._opening = step.opening
                    times = np.linspace(0.0, step.trajectory.duration, count + 1)[1:]
                    for t, q in zip(times, positions_at(step.trajectory, times), strict=True):
                        self._follow(q, step)
                        yield Frame(time + float(t), dict(self._poses), self._q, self._opening)
                    time += step.trajectory.duration
                case Grip():
                    self._opening = step.width
                    yield self._still(time := time + frame_s)
                case Release():
                    self._opening, self._poses[step.object] = step.opening, step.pose
                    yield self._still(time := time + frame_s)
                case Fall():
                    self._poses[step.object] = step.pose
                    yield self._still(time := time + frame_s)

    def _still(self, time: float) -> Frame:
        return Frame(time, dict(self._poses), self._q, self._opening)

    def _follow(self, q: NDArray[np.float64], move: Move) -> None:
        self._q = tuple(q.tolist())
        for carried in filter(None, (move.held, move.pushed)):
            T_world_object = self._robot.forward(q) @ carried.T_tool_object.matrix
            self._poses[carried.object] = Pose.from_matrix(T_world_object)
