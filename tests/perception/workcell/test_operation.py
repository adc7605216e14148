"""Plans carried out by feel, in a cell that is a script."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from tamp.execution.log import Deviation
from tamp.perception.cameras.camera import Camera, Frame
from tamp.perception.workcell.operation import Onlooker, Operation
from tamp.task import (
    Action,
    Attachment,
    Box,
    Grip,
    Move,
    Object,
    Plan,
    Pose,
    Release,
    RobotSpec,
    Step,
    Trajectory,
    load_robot,
)

HELD = Attachment("box", Pose())
WAY = Trajectory(np.array([0.0, 1.0]), np.zeros((2, 7)), np.zeros((2, 7)))
PICK = Action("pick", ("box",), (Move("approach", WAY, 0.06), Grip(HELD, 0.04), Move("lift", WAY, 0.04, HELD)))
CARRY = Action("move", ("box",), (Move("transfer", WAY, 0.04, HELD),))
PLACE = Action(
    "place",
    ("box",),
    (Move("lower", WAY, 0.04, HELD), Release("box", Pose((0.1, 0.0, 0.0)), 0.06), Move("retreat", WAY, 0.06)),
)
PLAN = Plan("t", "panda", 0, {"box": Pose()}, (0.0,) * 7, {}, (PICK, CARRY, PLACE, PICK))
BOX = Object("box", Box((0.04, 0.04, 0.04)), Pose())


@dataclass
class Script:
    """A cell whose fingers close to the openings that it is given, one after the other."""

    closes_to: list[float]
    drops_after: int = 1000
    said: list[str] = field(default_factory=list)
    now: float = 0.08
    time: float = 0.0

    robot: RobotSpec = field(default_factory=lambda: load_robot("panda"))
    cameras: tuple[Camera, ...] = ()

    def frame(self, camera: str) -> Frame:
        raise AssertionError("nothing is looked at")

    def configuration(self) -> tuple[float, ...]:
        return (0.0,) * 7

    def opening(self) -> float:
        return self.now

    def follow(self, trajectory: Trajectory) -> None:
        self.said.append("follow")
        self.time += trajectory.duration
        self.drops_after -= 1
        if self.drops_after == 0:
            self.now = 0.0

    def open_to(self, opening: float) -> None:
        self.now = opening

    def squeeze(self, force: float) -> None:
        self.said.append("squeeze")
        self.now = self.closes_to.pop(0)

    def wait(self, seconds: float) -> None:
        self.time += seconds


@dataclass
class Eyes:
    """Sees what it is told to see.

    Attributes:
        hanging: where the box lies in the tool frame after each lift, one after the other; None is not seen.
        passes: whether it meets nothing on its way.
        gone: what `watch` answers.
    """

    hanging: list[Pose | None] = field(default_factory=list)
    passes: bool = False
    gone: Deviation | None = None
    watched: list[dict[str, Pose]] = field(default_factory=list)
    carried: list[Attachment] = field(default_factory=list)

    def watch(self, expected: Mapping[str, Pose], moved: Collection[str]) -> Deviation | None:
        assert moved == ("box",), "what the hand has let go of"
        self.watched.append(dict(expected))
        return self.gone

    def in_hand(self, held: Attachment, expected: Mapping[str, Pose]) -> Pose | None:
        assert held == HELD
        assert expected == {"box": Pose()}, "where it was grasped"
        return self.hanging.pop(0) if self.hanging else None

    def can_carry(self, held: Attachment, expected: Mapping[str, Pose], steps: Sequence[Step]) -> bool:
        assert steps[:2] == (*CARRY.steps, *PLACE.steps[:1])
        self.carried.append(held)
        return self.passes


ONCE = Plan("t", "panda", 0, {"box": Pose()}, (0.0,) * 7, {}, (PICK, CARRY, PLACE))
DROOPING = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.8, 0.0))


def _run(cell: Script, limit: float = 100.0, onlooker: Onlooker | None = None) -> tuple[str, Deviation | None, int]:
    execution = Operation(cell, {"box": BOX}, limit, onlooker).carry_out(PLAN)
    return execution.status, execution.deviation, len(execution.log)


def test_a_plan_is_carried_out_to_its_end() -> None:
    execution = Operation(Script([0.04, 0.04]), {"box": BOX}, 100.0).carry_out(PLAN)
    assert (execution.status, execution.grasps_attempted, execution.grasps_succeeded) == ("done", 2, 2)
    assert execution.final_poses == {"box": Pose((0.1, 0.0, 0.0))}


def test_fingers_that_close_on_nothing_have_missed_and_the_hand_is_drawn_back_open() -> None:
    cell = Script([0.0])
    status, deviation, count = _run(cell)
    assert (status, count) == ("deviated", 1)
    assert deviation is not None
    assert deviation.kind == "missed"
    assert cell.said == ["follow", "squeeze", "follow"], "the lift is still done"
    assert cell.now == 0.06


def test_fingers_that_close_on_the_way_have_dropped_it() -> None:
    status, deviation, count = _run(Script([0.04], drops_after=3))
    assert (status, count) == ("deviated", 2)
    assert deviation is not None
    assert deviation.kind == "dropped"


def test_nothing_is_begun_after_the_limit() -> None:
    assert _run(Script([0.04]), limit=1.5)[0] == "timeout"


def test_whoever_watches_is_asked_once_the_hand_is_empty() -> None:
    eyes = Eyes(gone=Deviation("box", "disturbed", 0.0, 0.0))
    status, deviation, count = _run(Script([0.04]), onlooker=eyes)
    assert (status, count) == ("deviated", 3)
    assert eyes.watched == [{"box": Pose((0.1, 0.0, 0.0))}]
    assert deviation is not None
    assert deviation.kind == "disturbed"


def test_what_is_seen_to_hang_from_the_hand_and_would_meet_others_is_put_back() -> None:
    cell, eyes = Script([0.04] * 4), Eyes([DROOPING] * 4)
    operation = Operation(cell, {"box": BOX}, 100.0, eyes)
    for _ in range(2):
        cell.said.clear()
        execution = operation.carry_out(ONCE)
        assert (execution.status, len(execution.log)) == ("deviated", 1)
        assert execution.deviation is not None
        assert (execution.deviation.object, execution.deviation.kind) == ("box", "slipped")
        assert execution.deviation.angle == pytest.approx(0.8)
        assert execution.final_poses == {"box": Pose()}, "it stands where it stood"
        assert cell.said == ["follow", "squeeze", "follow", "follow", "follow"], "lowered, let go, and drawn back"
        assert cell.now == 0.06
    third = operation.carry_out(ONCE)
    assert third.status == "done", "the third time it is carried so"
    assert [d.kind for d in third.log[0].deviations] == ["slipped"]


def test_what_hangs_from_the_hand_is_carried_on_where_it_meets_nothing() -> None:
    eyes = Eyes([DROOPING], passes=True)
    execution = Operation(Script([0.04]), {"box": BOX}, 100.0, eyes).carry_out(ONCE)
    assert execution.status == "done"
    assert [held.T_tool_object for held in eyes.carried] == [DROOPING], "as it is seen, not as it was meant"
    assert [d.kind for d in execution.log[0].deviations] == ["slipped"]


@pytest.mark.parametrize("seen", [None, Pose.from_rpy((0.01, 0.0, 0.0), (0.0, 0.3, 0.0))])
def test_what_is_not_seen_in_the_hand_or_lies_nearly_as_meant_is_carried_on(seen: Pose | None) -> None:
    eyes = Eyes([seen])
    execution = Operation(Script([0.04]), {"box": BOX}, 100.0, eyes).carry_out(ONCE)
    assert (execution.status, execution.log[0].deviations, eyes.carried) == ("done", (), [])


@pytest.mark.parametrize("width", [0.017, 0.03])
def test_what_is_thinner_than_thought_is_held_as_long_as_it_is_there(width: float) -> None:
    assert _run(Script([width, width]))[0] == "done"
