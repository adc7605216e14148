"""Carrying out in a simulator, before they are taken, those parts of a plan in which something falls.

Falls are planned without the hand: what it holds up, or takes along, as it draws back is seen only here. So is what
executions have shown to end elsewhere though nothing falls, as a fruit that rolls on a dish.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.executor import WATCHFUL, execute
from tamp.execution.log import Deviation, Execution
from tamp.execution.monitor import Monitor
from tamp.pipeline.prepare import Setup
from tamp.pipeline.strategies.subproblems.plan_state import after, errands
from tamp.scoring.total_error import shortfall
from tamp.task import Fall, Plan, Pose, Release, Task
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Box = tuple[NDArray[np.float64], NDArray[np.float64]]

WORTH = 0.001  # what is carried out must gain, all objects together [m]
BESIDE = 0.08  # what is so near to an object, seen from above, may be met by the fingers that open beside it [m]
ROUGH = Monitor(0.03, 0.5)  # what ends no farther off is corrected once it lies there, if no better way is found
LENIENT = Monitor(WATCHFUL.position, WATCHFUL.angle, slip=0.05, slip_angle=1.0)  # it may lie otherwise in the hand


@dataclass(frozen=True)
class Astray:
    """What went otherwise than planned.

    Attributes:
        action: number of the last action of the part that was carried out.
        deviation: what was off.
    """

    action: int
    deviation: Deviation

    @property
    def correctable(self) -> bool:
        """Whether what is off lies so near to where it should that it can be corrected."""
        off = self.deviation
        near = off.distance <= ROUGH.position and off.angle <= ROUGH.angle
        return near and off.kind in ("misplaced", "disturbed")

    def __str__(self) -> str:
        return f"rehearsed: {self.deviation}"


def rehearsal(
    setup: Setup, plan: Plan, near: Mapping[str, Pose] | None = None, unsteady: Collection[str] = ()
) -> Iterator[Astray]:
    """Yield what goes astray in the simulator that settles scenes.

    How long an execution may take does not count: a plan that is never carried out has no such limit.

    Args:
        setup: what belongs to the task.
        plan: to be carried out.
        near: where all objects are before a plan that brings some merely near their goals. It does not matter there
            how they come to rest, if only that is better.
        unsteady: objects all of whose transfers are carried out, whether or not anything falls.
    """
    for last, part in uncertain_parts(setup.world.robot, plan, unsteady):
        few, simulator = among_few(setup, part), setup.settings.settling
        run = execute(*few, monitor=LENIENT, simulator=simulator, settle=False)
        if (
            run.status == "deviated"
            and run.deviation is not None
            and (near is None or not _is_better(setup.task, run, near))
        ):
            yield Astray(last, run.deviation)


def _is_better(task: Task, run: Execution, before: Mapping[str, Pose]) -> bool:
    """Whether what was put down elsewhere than the plan has it leaves the table better than it was."""
    misplaced = run.deviation is not None and run.deviation.kind == "misplaced"
    return misplaced and shortfall(task, {**before, **run.final_poses}) < shortfall(task, before) - WORTH


def among_few(setup: Setup, part: Plan) -> tuple[Task, Plan]:
    """The same with those objects alone that what it moves may meet where it is taken up or comes to rest.

    These are whatever is beside it there within a finger's reach, and all that lies over or under any of those: the
    plan keeps clear of everything else.
    """
    end = after(setup.world.robot, part).start
    boxes = {name: _box(setup, name, pose) for name, pose in part.start.items()}
    moved = [name for name, pose in part.start.items() if end[name] != pose]
    places = [*(boxes[name] for name in moved), *(_box(setup, name, end[name]) for name in moved)]
    kept, waiting = {*moved}, [(low - BESIDE, high + BESIDE) for low, high in places]
    while waiting:
        found = [name for name in boxes if name not in kept and any(_over(boxes[name], box) for box in waiting)]
        kept |= {*found}
        waiting = [boxes[name] for name in found]
    objects = tuple(replace(item, goal=None) for item in setup.task.objects if item.name in kept)
    start = {name: pose for name, pose in part.start.items() if name in kept}
    return replace(setup.task, objects=objects, goal=()), replace(part, start=start, goals={})


def _box(setup: Setup, name: str, pose: Pose) -> Box:
    """Lower and upper end of an object at a pose along x and y, (2,) each [m]."""
    points = setup.world.geometries[name].hull.vertices @ pose.matrix[:2, :3].T + pose.xyz[:2]
    return points.min(axis=0), points.max(axis=0)


def _over(one: Box, other: Box) -> bool:
    """Whether two boxes overlap, as seen from above."""
    return bool((one[0] < other[1]).all() and (other[0] < one[1]).all())


def uncertain_parts(robot: RobotModel, plan: Plan, unsteady: Collection[str] = ()) -> Iterator[tuple[int, Plan]]:
    """The parts of a plan in which something falls, or is let go that is unsteady; the hand is empty at both ends.

    Each begins where the plan says that what comes before it ends; the number of its last action comes with it.
    """
    done = 0
    for errand in errands(plan.actions):
        steps = [step for action in errand for step in action.steps]
        if any(isinstance(s, Fall) or (isinstance(s, Release) and s.object in unsteady) for s in steps):
            before = after(robot, replace(plan, actions=plan.actions[:done]))
            yield done + len(errand) - 1, replace(before, actions=errand)
        done += len(errand)
