"""The loop of a robot that is told no poses: look, estimate, settle, plan, act, and look again.

Nothing here reaches the true world: it works a `Workcell` and a task without start poses. So the same loop works a
simulated cell, a contest's, and a real one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Protocol

from tamp.errors import PlanningFailure
from tamp.execution.log import Execution
from tamp.perception.belief.belief import Belief
from tamp.perception.belief.observer import Observer
from tamp.perception.workcell.operation import Operation
from tamp.perception.workcell.workcell import Workcell
from tamp.pipeline.perceived.knowledge import Knowledge
from tamp.pipeline.prepare import Setup
from tamp.scoring import score
from tamp.scoring.ede import ede, mean_edge
from tamp.task import Plan, Pose, SymbolicFact, Task

ASTRAY = 0.02
"""An object that is seen to stand farther from its goal (EDE) than this is corrected [m]: estimates err too."""


class Planner(Protocol):
    """What makes plans from what is known, and keeps count; `tamp.pipeline.solving.job.Job` is one."""

    task: Task
    plans: list[Plan]
    executions: list[Execution]
    final_poses: dict[str, Pose]
    facts: tuple[SymbolicFact, ...]

    def plan(self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...]) -> bool:
        """Plan from a state at rest and add it to the plans; False where there is no plan."""

    def insist(self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...]) -> bool:
        """Plan again after a search in vain, while time is left; False where no plan is worth carrying out."""

    def worthwhile(self, setup: Setup) -> bool:
        """Whether the last plan does anything, and is worth its risk."""

    def forget(self) -> None:
        """Let the next search try again what single objects did not reach."""

    def keep(self, setup: Setup, execution: Execution) -> bool:
        """Add what is still good of the last plan after an execution that stopped; False where nothing is."""

    @property
    def left(self) -> Mapping[str, str]:
        """Objects whose goals the last plan leaves, and why."""

    @property
    def unfinished(self) -> bool:
        """Whether the last search ran out of time for anything."""


@dataclass
class Loop:
    """Rearranges what a workcell's cameras see.

    Attributes:
        cell: arm, gripper and cameras.
        knowledge: the task without its start, and what it is planned with.
        observer: looks.
        planner: plans.
        on_look: told what is believed after each look, for an onlooker; nothing comes back.
    """

    cell: Workcell
    knowledge: Knowledge
    observer: Observer
    planner: Planner
    on_look: Callable[[Belief], None] | None = None
    _belief: Belief | None = field(default=None, init=False)
    _operation: Operation = field(init=False)

    def __post_init__(self) -> None:
        task = self.knowledge.task
        objects = {obj.name: obj for obj in task.objects}
        self._operation = Operation(self.cell, objects, task.limits.execution_sim_s, self.observer)

    def run(self, *, execute: bool = True) -> None:
        """Look and plan; carry plans out and look again until all is where it should be, or nothing helps.

        Args:
            execute: whether plans are carried out; without it there is one look and one plan.
        """
        tuning, replans, corrections = self.knowledge.settings.tuning, 0, 0
        setup = self._look()
        if setup is None or not self._planned(setup) or not execute:
            return
        while True:
            before, known = self.planner.plans[-1], set(setup.start)
            execution = self._carried_out(before)
            seen = self._look(execution.final_poses, _lost(execution))
            if seen is None:
                self.planner.executions.append(execution)
                return
            same = set(seen.start) == known
            seen_poses = {**execution.final_poses, **seen.start}
            execution = replace(execution, final_poses=seen_poses, configuration=self.cell.configuration())
            self.planner.executions.append(execution)
            if execution.status == "timeout":
                return
            if execution.status == "deviated" and same and self.planner.keep(seen, execution):
                setup = seen
                continue
            if replans == tuning.max_replans or not self._worth(execution, seen, known, corrections):
                return
            if execution.status == "done" and same:
                corrections += 1
                self.planner.forget()
            setup, replans = seen, replans + 1
            if not self._planned(setup):
                return

    def _look(self, moved: Mapping[str, Pose] = MappingProxyType({}), lost: Collection[str] = ()) -> Setup | None:
        """Look, and make what is known ready to be planned; None where nothing is known.

        Args:
            moved: object -> where a plan should have brought it.
            lost: objects that the fingers have missed or lost, or that were seen not to be where they should.
        """
        wanted = {obj.name for obj in self.knowledge.task.objects if obj.goal is not None}
        expected = None if self._belief is None else self._belief.expecting(moved, lost)
        belief = self.observer.look(expected, wanted)
        if self.on_look is not None:
            self.on_look(belief)
        self._belief = Belief(belief.estimates)  # frames are large
        if not belief.poses:
            return None
        setup = self.knowledge.setup(belief.poses)
        self.planner.task, self.planner.final_poses = setup.task, dict(setup.start)
        return setup

    def _planned(self, setup: Setup) -> bool:
        """Whether there is a plan that is worth carrying out; where goals are missed other seeds are tried in time."""
        scene = setup, setup.start, self.cell.configuration()
        try:
            if self.planner.plan(*scene) and self.planner.worthwhile(setup):
                return True
            return bool(self._missed(setup)) and self.planner.insist(*scene)
        except PlanningFailure:
            return False

    def _missed(self, setup: Setup) -> set[str]:
        """Objects that are not at their goals, as far as is known."""
        met = score(setup.task, dict(setup.start), self.planner.facts).goals_met
        return {name for name in met if not met[name]}

    def _carried_out(self, plan: Plan) -> Execution:
        execution = self._operation.carry_out(plan)
        done = plan.actions[: len(execution.log)]
        self.planner.facts = self.knowledge.domain.facts_after(self.planner.facts, done)
        return execution

    def _worth(self, execution: Execution, seen: Setup, known: set[str], corrections: int) -> bool:
        """Whether to plan again after an execution."""
        if execution.status == "deviated" or set(seen.start) - known or self.planner.unfinished:
            return True
        if self._missed(seen):
            return corrections < self.knowledge.settings.tuning.max_replans
        return corrections < self.knowledge.settings.tuning.max_corrections and bool(self._astray(seen))

    def _astray(self, seen: Setup) -> Sequence[str]:
        """Objects that were to be brought to their goals and stand a little off."""
        return [
            name
            for name, place in seen.goals.items()
            if name not in self.planner.left
            and ede(mean_edge(seen.task.object(name).shape), seen.start[name], place.pose) > ASTRAY
        ]


def _lost(execution: Execution) -> tuple[str, ...]:
    """What fingers felt, or eyes saw, to be elsewhere than it was thought to be."""
    off = [deviation for entry in execution.log for deviation in entry.deviations]
    off += [] if execution.deviation is None else [execution.deviation]
    return tuple(dict.fromkeys(deviation.object for deviation in off))
