"""Single actions as the robot carries them out: their steps, what is put back, and what is off after them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import takewhile

from tamp.execution.controller import Operator
from tamp.execution.log import ActionLog, Deviation
from tamp.execution.monitor import Monitor, deviation, is_off
from tamp.execution.recovery import undone
from tamp.execution.simulator import Simulator
from tamp.task import Action, Attachment, Fall, Grip, Move, Pose, Release, Step

PUT_BACK = 2
"""How often an object that turns or slides in the fingers, and would then meet others, is put back where it was.

After that it is carried so.
"""

DRAWING_BACK = ("lift", "retreat")
"""What is still done of an action whose object is lost."""


def _is_transfer(step: Step) -> bool:
    return isinstance(step, Move) and step.phase == "transfer"


@dataclass
class _Tally:
    """What counts of one action so far."""

    expected: dict[str, Pose]
    attempted: int = 0
    succeeded: int = 0
    lost: Deviation | None = None
    placed: list[str] = field(default_factory=list)


class Performer:
    """Carries out one action after the other.

    Args:
        simulator: the world.
        operator: works its robot.
        monitor: when something counts as off; None never says so.
        can_carry: whether what is held can be carried on as it lies in the hand while further steps are done.
    """

    def __init__(
        self,
        simulator: Simulator,
        operator: Operator,
        monitor: Monitor | None,
        can_carry: Callable[[Attachment, Sequence[Step]], bool],
    ) -> None:
        self._simulator, self._operator, self._monitor = simulator, operator, monitor
        self._can_carry = can_carry
        self._put_back: Counter[str] = Counter()

    def perform(
        self, action: Action, expected: dict[str, Pose], after: Sequence[Step] = ()
    ) -> tuple[ActionLog, Deviation | None]:
        """Carry out an action.

        Args:
            action: what to do.
            expected: object -> pose (world frame) as the plan has it; brought up to date.
            after: the steps of the actions that come after it.

        Returns:
            The entry in the log, and the deviation that ends the plan at once, the hand being empty; None where it
            may go on.
        """
        began, start = self._simulator.time, dict(expected)
        self._operator.tracking_error = 0.0
        proven = self._operator.held is not None
        tally = _Tally(expected)
        for index, step in enumerate(action.steps):
            if tally.lost is not None and not (isinstance(step, Move) and step.phase in DRAWING_BACK):
                continue
            self._step(step, tally)
            if tally.attempted and not proven and isinstance(step, Move) and self._operator.held is not None:
                tally.succeeded, proven = tally.succeeded + 1, True
                if self._is_put_back(action.steps[: index + 1], (*action.steps[index + 1 :], *after), start, tally):
                    break
        poses = self._simulator.poses()
        deviations = (*self._slipped(), *self._misplaced(tally, poses))
        elapsed, error = self._simulator.time - began, self._operator.tracking_error
        entry = ActionLog(str(action), elapsed, tally.attempted, tally.succeeded, poses, deviations, error)
        return entry, None if self._monitor is None else tally.lost

    def _step(self, step: Step, tally: _Tally) -> None:
        if isinstance(step, Grip):
            tally.attempted += 1
            tally.expected.pop(step.attachment.object, None)
            tally.lost = self._operator.grip(step)
        elif isinstance(step, Release):
            self._operator.release(step)
            tally.expected[step.object] = step.pose
            tally.placed.append(step.object)
        elif isinstance(step, Fall):
            self._operator.await_fall(step.object)
            tally.expected[step.object] = step.pose
        else:
            self._operator.move(step)
            if step.pushed is not None:
                tally.expected[step.pushed.object] = self._operator.robot.tool() @ step.pushed.T_tool_object
                tally.placed.append(step.pushed.object)
            tally.lost = tally.lost or self._operator.lost()

    def _is_put_back(self, steps: Sequence[Step], ahead: Sequence[Step], start: dict[str, Pose], tally: _Tally) -> bool:
        """Take back a grip after which the object turned or slid between the fingers; whether it did.

        That is done where, carried on like this, it would sweep through what the plan holds to be free. What moved by
        less than counts as slipped may still meet something where it is put down: it gives way there.
        """
        held = self._operator.held
        if held is None or self._monitor is None or self._put_back[held.object] == PUT_BACK:
            return False
        name = held.object
        off = deviation(name, "slipped", held.T_tool_object, self._operator.in_tool(name))
        slipped = self._slipped()
        if not slipped and not is_off(off):
            return False
        way = ahead if slipped else tuple(takewhile(_is_transfer, ahead))
        if self._can_carry(Attachment(name, self._operator.in_tool(name)), way):
            return False
        self._put_back[name] += 1
        for step in undone(steps, start[name]):
            self._step(step, tally)
        tally.lost = off
        return True

    def _slipped(self) -> tuple[Deviation, ...]:
        held = self._operator.held
        if held is None or self._monitor is None:
            return ()
        slipped = self._monitor.slipped(held.object, held.T_tool_object, self._operator.in_tool(held.object))
        return () if slipped is None else (slipped,)

    def _misplaced(self, tally: _Tally, poses: dict[str, Pose]) -> tuple[Deviation, ...]:
        return () if self._monitor is None else self._monitor.compare(tally.expected, poses, tally.placed)
