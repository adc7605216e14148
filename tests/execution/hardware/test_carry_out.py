"""A plan carried out by a controller: what it is asked for, in which order, and what stops it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tamp.cli import main
from tamp.errors import PlanError, TampError
from tamp.execution.hardware.carry_out import carry_out
from tamp.execution.hardware.controller import make_controller
from tamp.execution.hardware.dry_run import DryRun
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
    Task,
    Trajectory,
    load_robot,
)

ROBOT = load_robot("panda")
HELD = Attachment("box", Pose())
TASK = Task("task", (Object("box", Box((0.04, 0.04, 0.04)), Pose((0.1, 0.0, 0.02)), None),))


def moved(by: float, seconds: float = 1.0) -> Trajectory:
    """Of one joint, from home or back to it where it is negative [rad]."""
    home = np.array(ROBOT.home)
    ends = np.array([home, home + abs(by) * np.eye(7)[0]])
    return Trajectory(np.array([0.0, seconds]), ends if by > 0 else ends[::-1].copy(), np.zeros((2, 7)))


TRANSIT, LIFT = Move("transit", moved(0.2), 0.06), Move("lift", moved(-0.2), 0.04, HELD)
PICK = Action("pick", ("box",), (TRANSIT, Grip(HELD, 0.04), LIFT))
PLACE = Action("place", ("box",), (Move("transfer", moved(0.2), 0.04, HELD), Release("box", Pose(), 0.08)))
PLAN = Plan("task", "panda", 0, {"box": Pose((0.1, 0.0, 0.02))}, ROBOT.home, {}, (PICK, PLACE))


class Clumsy(DryRun):
    """Notes what it is asked for, and loses what it holds after so many motions with it."""

    def __init__(self, robot: RobotSpec, carries: int = 9) -> None:
        super().__init__(robot)
        self.asked: list[tuple[str, float]] = []
        self.carries = carries

    def follow(self, trajectory: Trajectory, opening: float) -> None:
        self.asked.append(("follow", trajectory.duration))
        self.carries -= self._pressing
        super().follow(trajectory, opening)

    def open_to(self, opening: float) -> None:
        self.asked.append(("open_to", opening))
        super().open_to(opening)

    def grip(self, force: float) -> None:
        self.asked.append(("grip", force))
        super().grip(force)

    def holds(self) -> bool:
        return super().holds() and self.carries > 0


def test_a_controller_is_asked_for_motions_and_the_hand_in_the_plan_s_order() -> None:
    controller, done = Clumsy(ROBOT), []
    outcome = carry_out(TASK, PLAN, controller, lambda action: done.append(str(action)))
    assert (outcome.done, outcome.stopped) == (2, "") and done == ["pick(box)", "place(box)"]
    whats = [what for what, _ in controller.asked]
    assert whats == ["open_to", "follow", "grip", "follow", "follow", "open_to"]
    assert controller.asked[0] == ("open_to", 0.06) and controller.asked[2] == ("grip", 20.0)
    assert controller.time == pytest.approx(3.0 + 0.2 + 0.6 + 0.4)


def test_fingers_close_gently_hold_as_firmly_as_the_plan_says_and_ease_before_they_open() -> None:
    controller, (transit, grip, lift) = Clumsy(ROBOT), PICK.steps
    firm = replace(PICK, steps=(transit, replace(grip, force=35.0), lift))
    assert carry_out(TASK, replace(PLAN, actions=(firm, PLACE)), controller).done == 2
    assert [asked for asked in controller.asked if asked[0] != "follow"] == [
        ("open_to", 0.06), ("grip", 20.0), ("grip", 35.0), ("grip", 20.0), ("open_to", 0.08),
    ]  # fmt: skip


def test_a_plan_stops_where_the_hand_has_lost_what_it_held() -> None:
    outcome = carry_out(TASK, PLAN, Clumsy(ROBOT, carries=2))
    assert outcome.done == 1 and outcome.stopped == "place(box): the hand does not hold box"


def test_a_plan_from_elsewhere_moves_nothing() -> None:
    controller = Clumsy(ROBOT)
    with pytest.raises(PlanError, match=r"the plan starts 0\.500 rad from where the arm stands"):
        carry_out(TASK, replace(PLAN, home=(0.5, *ROBOT.home[1:])), controller)
    with pytest.raises(PlanError, match="the plan is about 'box'; the task has ball"):
        carry_out(replace(TASK, objects=(replace(TASK.objects[0], name="ball"),)), PLAN, controller)
    assert not controller.asked


def test_a_dry_run_holds_motions_to_the_robot_s_limits() -> None:
    for step, said in (
        (Move("transit", moved(3.0), 0.08), "out of its limits"),
        (Move("transit", moved(-0.2), 0.08), "begins 0.2000 rad from where the arm stands"),
        (Move("transit", moved(0.2), 0.09), "the fingers open from 0 to 0.08 m"),
        (Release("box", Pose(), 0.1), "the fingers open from 0 to 0.08 m, not to 0.1"),
    ):
        outcome = carry_out(TASK, replace(PLAN, actions=(Action("move", (), (step,)),)), DryRun(ROBOT))
        assert outcome.done == 0 and said in outcome.stopped
    racing = replace(moved(0.2), velocities=np.full((2, 7), 9.0))
    assert (
        "faster than its limit"
        in carry_out(
            TASK, replace(PLAN, actions=(Action("move", (), (Move("transit", racing, 0.08),)),)), DryRun(ROBOT)
        ).stopped
    )


@pytest.mark.parametrize("name", ["no_such_module:Class", "json", "json:nothing", "json:__doc__", ""])
def test_what_is_no_controller_is_refused_in_one_sentence(name: str) -> None:
    with pytest.raises(TampError, match=r"controller .* cannot be") as error:
        make_controller(name, ROBOT)
    assert "\n" not in str(error.value)


def test_the_command_runs_a_plan_dry(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task = Path(__file__).parents[3] / "scenarios" / "one_object.yaml"
    plan, told = tmp_path / "plan.json", tmp_path / "told.json"
    assert main(["plan", str(task), "-o", str(plan)]) == 0
    capsys.readouterr()
    assert main(["execute", str(task), str(plan), "--controller", "dry-run", "--json", str(told)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "done: 4 of 4 actions"
    assert json.loads(told.read_text())["seconds"] > 3.0
    assert main(["execute", str(task), str(plan), "--controller", "dry-run", "--unchecked"]) == 2
    assert "for simulators" in capsys.readouterr().err
