"""A third party's simulator in runs: what it raises, or answers wrongly, is one sentence that names it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tamp.errors import PartError, RobotError
from tamp.execution.guard import GuardedSimulator
from tamp.execution.simulator import Touch
from tamp.execution.simulators import make_simulator
from tamp.task import Box, Object, Pose
from tamp.task.robots import load_robot

BOX = Object("box", Box((0.05, 0.05, 0.08)), Pose((0.1, 0.2, 0.04)))
PANDA = load_robot("panda")


class Arm:
    """A robot that does nothing."""

    spec = PANDA
    configuration_is: Any = PANDA.home
    opening_is: Any = 0.08

    def configuration(self) -> Any:
        return self.configuration_is

    def opening(self) -> Any:
        return self.opening_is

    def finger_speed(self) -> Any:
        return np.float32(0.0)

    def tool(self) -> Any:
        return np.eye(4)

    def command(self, q: Any, velocity: Any = None) -> None:
        raise ValueError(f"{len(q)} joints")

    def open_to(self, opening: float) -> None:
        """Does nothing."""

    def squeeze(self, force: float) -> None:
        """Does nothing."""

    def touching(self, name: str) -> Any:
        return [0, 1]


class Still:
    """A world in which nothing happens."""

    on_step: Any = None
    time: Any = 0.0
    given: Any = None
    arm: Any = Arm

    def __init__(self, objects: Any, poses: Any, *, table: Any, robot: Any, q: Any) -> None:
        self.objects = {item.name: item for item in objects}
        self.robot = None if robot is None else self.arm()

    def __enter__(self) -> Still:
        return self

    def __exit__(self, *error: object) -> None:
        """Frees nothing."""

    def step(self, count: int = 1) -> None:
        self.time += count

    def pose(self, name: str) -> Any:
        return self.objects[name].pose

    def poses(self) -> Any:
        return {name: item.pose for name, item in self.objects.items()} if self.given is None else self.given

    def place(self, name: str, pose: Pose) -> None:
        raise SystemExit("no more")

    def speeds(self) -> Any:
        return dict.fromkeys(self.objects, (0.0, 0)) if self.given is None else self.given

    def limit_speeds(self, linear: float, angular: float) -> None:
        """Does nothing."""

    def touches(self) -> Any:
        return [Touch("box", "table", (0.0, 0.0, 1.0), 0.0, 1.0)] if self.given is None else self.given


class Unlicensed(Still):
    def __init__(self, *given: Any, **options: Any) -> None:
        raise OSError("no licence")


class Robotless(Still):
    arm = staticmethod(lambda: None)


class Unmeshed(Still):
    def __init__(self, *given: Any, **options: Any) -> None:
        raise RobotError("robot panda: no mesh")


def world(kind: type = Still, robot: Any = None) -> Any:
    return make_simulator(f"{__name__}:{kind.__name__}", (BOX,), robot=robot)


def test_answers_that_fit_are_passed_on() -> None:
    seen: list[float] = []
    with world(robot=PANDA) as made:
        assert isinstance(made, GuardedSimulator)
        made.step(3)
        made.on_step = seen.append
        assert made.on_step == seen.append and made.time == 3.0
        assert made.poses() == {"box": BOX.pose} == {"box": made.pose("box")}
        assert made.speeds() == {"box": (0.0, 0)} and made.touches()[0].b == "table"
        assert made.robot.configuration().dtype == np.float64 and made.robot.spec is PANDA
        assert made.robot.touching("box") == (False, True) and made.robot.finger_speed() == 0.0


@pytest.mark.parametrize(
    ("given", "method", "said"),
    [
        ({}, "poses", r"poses gave \{\}; valid is a tamp.Pose of each of box"),
        ({"box": np.zeros(3)}, "poses", "poses gave .*; valid is a tamp.Pose of each of box"),
        ({"box": (0.0, math.nan)}, "speeds", "speeds gave .*; valid is two finite numbers for each object"),
        ({"box": 0.0}, "speeds", "speeds gave .*; valid is two finite numbers"),
        ([("box", "table")], "touches", r"touches gave \('box', 'table'\); valid is a Touch"),
        (5, "touches", "touches raised TypeError: 'int' object is not iterable"),
    ],
)
def test_an_answer_of_the_world_that_fits_nothing_is_told(given: Any, method: str, said: str) -> None:
    made = world()
    made._world.given = given
    with pytest.raises(PartError, match=rf"simulator '{__name__}:Still': {said}") as refused:
        getattr(made, method)()
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (
            lambda made: made.robot.command((0.0,) * 7),
            r"robot.command raised ValueError: 7 joints at .*guard.py:",
        ),
        (lambda made: made.robot.tool(), "robot.tool gave array.*; valid is a tamp.Pose"),
        (lambda made: made.place("box", BOX.pose), r"place raised SystemExit: no more at .*test_guard.py:\d+"),
        (lambda made: made.pose("ball"), "pose raised KeyError: 'ball'"),
    ],
)
def test_what_a_simulator_raises_is_told(ask: Any, said: str) -> None:
    with pytest.raises(PartError, match=rf"simulator '{__name__}:Still': {said}"):
        ask(world(robot=PANDA))


@pytest.mark.parametrize("q", [(0.0,) * 3, np.full(7, math.nan), None, "abc"])
def test_an_arm_is_where_finite_numbers_say(q: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Arm, "configuration_is", q)
    monkeypatch.setattr(Arm, "opening_is", q)
    made = world(robot=PANDA)
    with pytest.raises(PartError, match=r"robot.configuration gave .*; valid is 7 finite joint positions"):
        made.robot.configuration()
    with pytest.raises(PartError, match=r"robot.opening gave .*; valid is a finite number"):
        made.robot.opening()


def test_a_world_that_cannot_be_made_is_told() -> None:
    with pytest.raises(PartError, match=r"Unlicensed': its construction raised OSError: no licence at "):
        world(Unlicensed)
    with pytest.raises(PartError, match=r"Robotless': robot gave None; valid is one exactly where"):
        world(Robotless, robot=PANDA)
    with pytest.raises(RobotError, match=r"^robot panda: no mesh$"):
        world(Unmeshed)
