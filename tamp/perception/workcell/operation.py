"""Carrying out a plan in a workcell by feel: where objects are is known from the plan alone until somebody looks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from tamp.execution.log import ActionLog, Deviation, Execution, Kind, Status
from tamp.execution.simulator import GRAVITY
from tamp.perception.workcell.workcell import Workcell
from tamp.task import Action, Fall, Grip, Move, Object, Plan, Pose, Release, Step
from tamp.world.robot.model import robot_model

EMPTY = 0.4
"""Fingers that have closed below this share of an object's width hold nothing, or not it."""

LEAST = 0.0008
"""Nor do fingers nearer than this [m]."""

FALL_S = 2.0
"""How long an object that was let go tilted may take to fall flat [s]."""

REST_S = 0.15
"""A moment for an object that was let go [s]."""

DRAWING_BACK = ("lift", "retreat")
"""What is still done of an action whose object is lost."""

Watch = Callable[[Mapping[str, Pose]], Deviation | None]
"""Told where everything should be while the hand is empty; answers with what clearly is not there."""


@dataclass
class _Hand:
    """What the fingers are thought to hold."""

    grip: Grip | None = None
    opened: float = 0.0


@dataclass
class _Tally:
    """What counts of one action."""

    attempted: int = 0
    succeeded: int = 0
    lost: Deviation | None = None


@dataclass
class Operation:
    """Carries out plans in a workcell.

    Attributes:
        cell: where.
        objects: by name; their masses and friction decide how firmly they are held.
        limit_s: nothing is begun after this time in the cell [s].
        watch: asked after each time that the hand has let go of something; None looks at nothing.
    """

    cell: Workcell
    objects: Mapping[str, Object]
    limit_s: float
    watch: Watch | None = None
    _hand: _Hand = field(default_factory=_Hand)

    def carry_out(self, plan: Plan) -> Execution:
        """Run a plan to its end, or until fingers close on nothing, lose what they hold, or the watch objects.

        Returns:
            The execution, with poses as the plan has them as far as it was carried out: look before you trust them.
        """
        began, expected = self.cell.time, dict(plan.start)
        log: list[ActionLog] = []
        stop: Deviation | None = None
        status: Status = "done"
        for action in plan.actions:
            entry, lost = self._perform(action, expected)
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
        moved = any(isinstance(s, Release | Fall) or (isinstance(s, Move) and s.pushed) for s in action.steps)
        return None if self.watch is None or self._hand.grip is not None or not moved else self.watch(expected)

    def _perform(self, action: Action, expected: dict[str, Pose]) -> tuple[ActionLog, Deviation | None]:
        began, tally = self.cell.time, _Tally()
        for step in action.steps:
            if tally.lost is None or (isinstance(step, Move) and step.phase in DRAWING_BACK):
                self._step(step, expected, tally)
        deviations = () if tally.lost is None else (tally.lost,)
        elapsed = self.cell.time - began
        entry = ActionLog(str(action), elapsed, tally.attempted, tally.succeeded, expected, deviations, 0.0)
        return entry, tally.lost

    def _step(self, step: Step, expected: dict[str, Pose], tally: _Tally) -> None:
        match step:
            case Move():
                self._move(step, expected, tally)
            case Grip():
                tally.attempted += 1
                tally.lost = self._grip(step)
            case Release():
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
        self._hand = _Hand(grip, self.cell.opening())
        item = self.objects[grip.attachment.object]
        self.cell.squeeze(self.cell.robot.gripper.holding_force(item.mass * GRAVITY, item.friction))
        return self._lost("missed")

    def _lost(self, kind: Kind) -> Deviation | None:
        """Where the fingers have closed on nothing: they open again, and the hand counts as empty."""
        grip = self._hand.grip
        if grip is None or self.cell.opening() > max(LEAST, EMPTY * grip.width):
            return None
        self.cell.open_to(self._hand.opened)
        self._hand = _Hand()
        return Deviation(grip.attachment.object, kind, math.nan, math.nan)
