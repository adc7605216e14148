"""The kit for simulators: those that come along fit, and of each broken one its fault is told."""

from __future__ import annotations

import math
import re
import time
from dataclasses import replace
from typing import Any, ClassVar

import pytest

from tamp.conformance import checks
from tamp.conformance.simulator import BOX, check_simulator
from tamp.execution.simulators import SIMULATORS
from tamp.task import Pose

pytest.importorskip("pybullet")

from tamp.execution.pybullet.simulator import PyBulletSimulator


@pytest.mark.parametrize("name", SIMULATORS)
def test_a_simulator_that_comes_along_fits(name: str) -> None:
    pytest.importorskip(SIMULATORS[name].library)
    judgement = check_simulator(name)
    assert judgement.fits and {f.outcome for f in judgement.findings} == {"ok"}, str(judgement)


class Wrapped:
    """A robot of which some answers are others."""

    def __init__(self, robot: Any, answers: dict[str, Any]) -> None:
        self._robot, self._answers = robot, answers

    def __getattr__(self, name: str) -> Any:
        return self._answers[name] if name in self._answers else getattr(self._robot, name)


class Base(PyBulletSimulator):
    """PyBullet's in this module, of which one thing is broken each time."""

    robot_answers: ClassVar[dict[str, Any]] = {}

    def __init__(self, objects: Any, poses: Any, **options: Any) -> None:
        super().__init__(objects, poses, **options)
        if self.robot is not None and self.robot_answers:
            self.robot: Any = Wrapped(self.robot, self.robot_answers)

    def by(self, dx: float, pose: Pose) -> Pose:
        return replace(pose, xyz=(pose.xyz[0] + dx, *pose.xyz[1:]))


class Raising(Base):
    def step(self, count: int = 1) -> None:
        raise RuntimeError("the engine is out of fuel")


class Hanging(Base):
    def step(self, count: int = 1) -> None:
        time.sleep(1000)


class Deaf(Base):
    """Never calls on_step."""

    on_step = property(lambda self: None, lambda self, value: None)  # type: ignore[assignment]


class Nameless(Base):
    def __init__(self, objects: Any, poses: Any, **options: Any) -> None:
        super().__init__(objects, poses, **options)
        self.objects = {}


class Shifted(Base):
    def poses(self) -> dict[str, Pose]:
        return {name: self.by(0.1, pose) for name, pose in super().poses().items()}

    def pose(self, name: str) -> Pose:
        return self.by(0.1, super().pose(name))


class Forked(Base):
    def poses(self) -> dict[str, Pose]:
        return {name: self.by(1e-4, pose) for name, pose in super().poses().items()}


class Double(Base):
    def step(self, count: int = 1) -> None:
        super().step(2 * count)


class Millimetres(Base):
    def speeds(self) -> dict[str, tuple[float, float]]:
        return {name: (1000 * linear, angular) for name, (linear, angular) in super().speeds().items()}


class Unlimited(Base):
    def limit_speeds(self, linear: float, angular: float) -> None:
        """Does nothing."""


class Flipped(Base):
    def touches(self) -> Any:
        return tuple(replace(t, normal=tuple(-x for x in t.normal)) for t in super().touches())


class Renaming(Base):
    def touches(self) -> Any:
        return tuple(
            replace(t, a=t.a.replace("table", "desk"), b=t.b.replace("table", "desk")) for t in super().touches()
        )


class Intangible(Base):
    def touches(self) -> Any:
        return ()


class Elsewhere(Base):
    def place(self, name: str, pose: Pose) -> None:
        super().place(name, self.by(0.01, pose))


class Pushing(Base):
    """Moves all that is there."""

    def place(self, name: str, pose: Pose) -> None:
        super().place("other", self.by(0.01, self.pose("other")))
        super().place(name, pose)


class Random(Base):
    made = 0

    def __init__(self, objects: Any, poses: Any, **options: Any) -> None:
        type(self).made += 1
        poses = {name: self.by(1e-9 * self.made, pose) for name, pose in poses.items()}
        super().__init__(objects, poses, **options)


class Robotless(Base):
    def __init__(self, objects: Any, poses: Any, **options: Any) -> None:
        super().__init__(objects, poses, **options)
        self.robot = None


class Homing(Base):
    """Begins at home whatever it is told."""

    def __init__(self, objects: Any, poses: Any, *, q: Any = None, **options: Any) -> None:
        super().__init__(objects, poses, **options)


class Paralysed(Base):
    robot_answers: ClassVar = {"command": lambda q, velocity=None: None}


class Stiff(Base):
    robot_answers: ClassVar = {"open_to": lambda opening: None}


class Numb(Base):
    robot_answers: ClassVar = {"touching": lambda name: (False, False)}


class Weak(Base):
    robot_answers: ClassVar = {"squeeze": lambda force: None}


class Lost(Base):
    robot_answers: ClassVar = {"configuration": lambda: [math.nan] * 7}


class Short(Base):
    robot_answers: ClassVar = {"configuration": lambda: [0.0] * 3}


class Vague(Base):
    robot_answers: ClassVar = {"opening": lambda: math.nan}


class Bare(Base):
    def poses(self) -> Any:
        return {name: pose.xyz for name, pose in super().poses().items()}


class Speechless(Base):
    robot_answers: ClassVar = {"finger_speed": None}


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (Raising, "time: it raised RuntimeError: the engine is out of fuel at .*test_simulator.py:"),
        (Hanging, "time: it had not come back after "),
        (Deaf, "time: on_step was called 0 times in 3 steps"),
        (Nameless, r"objects: objects is \[\]; valid is what the world was made of"),
        (Shifted, r"objects: box begins at \(0.200, 0.200, 0.040\); its own pose is at \(0.100, 0.200, 0.040\)"),
        (Forked, r"objects: poses\(\) must have what pose\(name\) says of every object"),
        (Double, "time: time is 0.025 s after 3 steps; a step is 0.00416667 s"),
        (Millimetres, r"falls: speeds\(\) says 24\d+\.\d+ m/s of an object that falls at 2.453 m/s"),
        (Unlimited, r"falls: an object moves at 2.\d+ m/s right after limit_speeds\(0.1, 0.1\)"),
        (Flipped, r"rest: touches\(\) press an object of 2.94 N upward with -2.94 N; .*`normal` points from b to a"),
        (Renaming, r"rest: touches\(\) says .*desk.* of an object that stands on the table, which is called 'table'"),
        (Intangible, r"rest: touches\(\) says \[\] of an object that stands on the table"),
        (Elsewhere, r"place: place\(\) at .* leaves an object at "),
        (Pushing, r"place: place\(\) moved another object"),
        (Random, "repetition: the same world and the same steps end in other poses the second time"),
        (Robotless, "robot: robot is None in a world that was made with one"),
        (Speechless, "robot: its robot lacks finger_speed; tamp.execution.simulator.Robot says what they do"),
        (Lost, "robot: the arm begins inf rad from the robot's home"),
        (Short, "robot: the arm has 3 joint positions; its robot has 7 joints"),
        (Vague, "robot: the fingers begin nan m apart"),
        (Bare, r"objects: poses\(\) has \(.*\); valid is a tamp.Pose of each object"),
        (Homing, "start: the arm begins 0.020 rad from the configuration q"),
        (Paralysed, "arm: the arm is 0.020 rad from what was commanded, 1 s later"),
        (Stiff, r"hand: the fingers are 0.0\d+ m apart 2 s after open_to\(0.06\)"),
        (Numb, r"hand: touching\(\) does not say that fingers touch what is between them"),
        (Weak, r"hand: touching\(\) does not say that fingers touch what is between them"),
    ],
)
def test_the_fault_of_a_broken_simulator_is_told(broken: type, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "PATIENCE_S", 2.0 if broken is Hanging else checks.PATIENCE_S)
    judgement = check_simulator(f"{__name__}:{broken.__name__}")
    (told,) = [f"{f.check}: {f.text}" for f in judgement.findings if f.outcome == "wrong"]
    assert re.search(said, told) and "\n" not in told, told


def test_what_is_no_simulator_is_told_and_nothing_else() -> None:
    judgement = check_simulator("json:JSONDecoder")
    assert [f.outcome for f in judgement.findings] == ["wrong"] and not judgement.fits
    assert judgement.as_dict()["simulator"] == "json:JSONDecoder" and "lacks __enter__" in str(judgement)
    assert BOX.name in str(check_simulator(f"{__name__}:Shifted"))
