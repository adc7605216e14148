"""Carrying out a plan in a workcell by feel: where objects are is known from the plan alone until somebody looks."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from tamp.execution.action_execution import DRAWING_BACK, PUT_BACK
from tamp.execution.log import ActionLog, Deviation, Execution, Kind, Status
from tamp.execution.monitor import Monitor
from tamp.execution.recovery import undone
from tamp.execution.simulator import GRAVITY
from tamp.perception.workcell.workcell import Workcell
from tamp.task import Action, Attachment, Fall, Grip, Move, Object, Plan, Pose, Release, Step
from tamp.task.robot import GENTLE_FORCE
from tamp.world.robot.model import robot_model

EMPTY = 0.4
"""Fingers that have closed below this share of an object's width hold nothing, or not it."""

LEAST = 0.0008
"""Nor do fingers nearer than this [m]."""

FALL_S = 2.0
"""How long an object that was let go tilted may take to fall flat [s]."""

REST_S = 0.15
"""A moment for an object that was let go [s]."""


class Onlooker(Protocol):
    """Looks on while a plan is carried out; everywhere `expected` is object -> where it should be (world frame)."""

    def watch(self, expected: Mapping[str, Pose], moved: Collection[str]) -> Deviation | None:
        """Something that clearly is not where it should be, the hand being empty; what was just moved above all."""

    def in_hand(self, held: Attachment, expected: Mapping[str, Pose]) -> Pose | None:
        """Where a held object lies in the tool frame, by what is seen of it; None where that tells nothing."""

    def can_carry(self, held: Attachment, expected: Mapping[str, Pose], steps: Sequence[Step]) -> bool:
        """Whether an object, as it lies in the hand, meets no other while the steps are done."""


@dataclass
class _Hand:
    """What the fingers are thought to hold, how far they were open before [m], and how they close and hold [N]."""

    grip: Grip | None = None
    opened: float = 0.0
    forces: tuple[float, float] = (GENTLE_FORCE, GENTLE_FORCE)


@dataclass
class _Tally:
    """What counts of one action."""

    attempted: int = 0
    succeeded: int = 0
    lost: Deviation | None = None
    slipped: tuple[Deviation, ...] = ()


@dataclass
class Operation:
    """Carries out plans in a workcell.

    Attributes:
        cell: where.
        objects: by name; their masses and friction decide how firmly they are held.
        limit_s: nothing is begun after this time in the cell [s].
        onlooker: asked after each lift how the object lies in the hand, and after each time that the hand has let go of
            something or pushed it; None looks at nothing.
        monitor: how far an object may move in the hand.
    """

    cell: Workcell
    objects: Mapping[str, Object]
    limit_s: float
    onlooker: Onlooker | None = None
    monitor: Monitor = field(default_factory=Monitor)
    _hand: _Hand = field(default_factory=_Hand)
    _put_back: Counter[str] = field(default_factory=Counter)

    def carry_out(self, plan: Plan) -> Execution:
        """Run a plan to its end, or until fingers close on nothing, lose what they hold, or the onlooker objects.

        What is seen to have turned in the hand so that it would meet others on its way is put back where it was.

        Returns:
            The execution, with poses as the plan has them as far as it was carried out: look before you trust them.
        """
        began, expected = self.cell.time, dict(plan.start)
        log: list[ActionLog] = []
        stop: Deviation | None = None
        status: Status = "done"
        for index, action in enumerate(plan.actions):
            after = [step for later in plan.actions[index + 1 :] for step in later.steps]
            entry, lost = self._perform(action, expected, after)
            log.append(entry)
            stop = lost or self._seen(action, expected)
            if stop is not None:
                status = "deviated"
                break
            if self.cell.time > self.limit_s:
                status = "timeout"
                break
        return Execution(
            status, expected, self.cell.configuration(), tuple(log), self.cell.time - began, deviation=stop
        )

    def _seen(self, action: Action, expected: Mapping[str, Pose]) -> Deviation | None:
        moved = dict.fromkeys(name for step in action.steps if (name := _moved(step)) is not None)
        if self.onlooker is None or self._hand.grip is not None or not moved:
            return None
        return self.onlooker.watch(expected, tuple(moved))

    def _perform(
        self, action: Action, expected: dict[str, Pose], after: Sequence[Step]
    ) -> tuple[ActionLog, Deviation | None]:
        began, tally, start = self.cell.time, _Tally(), dict(expected)
        for index, step in enumerate(action.steps):
            if tally.lost is not None and not (isinstance(step, Move) and step.phase in DRAWING_BACK):
                continue
            proven = tally.succeeded > 0
            self._step(step, expected, tally)
            if tally.succeeded and not proven:
                ahead = (*action.steps[index + 1 :], *after)
                if self._is_put_back(action.steps[: index + 1], ahead, start, expected, tally):
                    break
        deviations = (*tally.slipped, *(() if tally.lost is None else (tally.lost,)))
        elapsed = self.cell.time - began
        entry = ActionLog(str(action), elapsed, tally.attempted, tally.succeeded, expected, deviations, 0.0)
        return entry, tally.lost

    def _is_put_back(
        self,
        steps: Sequence[Step],
        ahead: Sequence[Step],
        start: Mapping[str, Pose],
        expected: dict[str, Pose],
        tally: _Tally,
    ) -> bool:
        """Take back a grip after which the object is seen to have moved in the hand and cannot be carried so."""
        grip = self._hand.grip
        if self.onlooker is None or grip is None:
            return False
        held, name = grip.attachment, grip.attachment.object
        seen = self.onlooker.in_hand(held, start)
        slipped = None if seen is None else self.monitor.slipped(name, held.T_tool_object, seen)
        if seen is None or slipped is None:
            return False
        as_seen = replace(held, T_tool_object=seen)
        if self._put_back[name] == PUT_BACK or self.onlooker.can_carry(as_seen, start, ahead):
            tally.slipped = (slipped,)
            return False
        self._put_back[name] += 1
        for step in undone(steps, start[name]):
            self._step(step, expected, tally)
        tally.lost = slipped
        return True

    def _step(self, step: Step, expected: dict[str, Pose], tally: _Tally) -> None:
        match step:
            case Move():
                self._move(step, expected, tally)
            case Grip():
                tally.attempted += 1
                tally.lost = self._grip(step)
            case Release():
                gentle, firm = self._hand.forces
                if self._hand.grip is not None and firm > gentle:
                    self.cell.squeeze(gentle)
                self._hand.grip = None
                self.cell.open_to(step.opening)
                self.cell.wait(REST_S)
                expected[step.object] = step.pose
            case Fall():
                self.cell.wait(FALL_S)
                expected[step.object] = step.pose

    def _move(self, move: Move, expected: dict[str, Pose], tally: _Tally) -> None:
        if self._hand.grip is None and tally.lost is None:
            self.cell.open_to(move.opening)
        self.cell.follow(move.trajectory)
        if move.pushed is not None:
            robot = robot_model(self.cell.robot)
            tool = Pose.from_matrix(robot.forward(move.trajectory.positions[-1]))
            expected[move.pushed.object] = tool @ move.pushed.T_tool_object
        if self._hand.grip is not None:
            tally.lost = self._lost("dropped")
            if tally.lost is None and tally.attempted:
                tally.succeeded = 1

    def _grip(self, grip: Grip) -> Deviation | None:
        item, opened = self.objects[grip.attachment.object], self.cell.opening()
        gentle, firm = self.cell.robot.gripper.pressing(item.mass * GRAVITY, item.friction, grip.force)
        self._hand = _Hand(grip, opened, (gentle, firm))
        self.cell.squeeze(gentle)
        if firm > gentle:
            self.cell.squeeze(firm)
        return self._lost("missed")

    def _lost(self, kind: Kind) -> Deviation | None:
        """Where the fingers have closed on nothing: they open again, and the hand counts as empty."""
        grip = self._hand.grip
        if grip is None or self.cell.opening() > max(LEAST, EMPTY * grip.width):
            return None
        self.cell.open_to(self._hand.opened)
        self._hand = _Hand()
        return Deviation(grip.attachment.object, kind, math.nan, math.nan)


def _moved(step: Step) -> str | None:
    """The object that a step lets go of or pushes."""
    if isinstance(step, Move):
        return None if step.pushed is None else step.pushed.object
    return step.object if isinstance(step, Release | Fall) else None
