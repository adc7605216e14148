"""An agent as OCRTOC 2024 has it: what it is given, what becomes of its actions, and a whole run of one."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tamp.contest.adapters import Agent2024, AgentBase
from tamp.contest.adapters.ocrtoc2024 import IMAGES, Observation, write_targets, xyzrpy
from tamp.contest.api.host import load
from tamp.task import load_robot
from tamp.task.files.yaml_document import parse_document
from tamp.world.kinematics.inverse import inverse
from tamp.world.robot.model import robot_model
from tests.contest.adapters.robots import FakeRobot, goal_of, run_tiny

AGENT = """
import numpy as np
from ocrtoc_env.src.agent_base import AgentBase

WAY = {way}


class MyAgent(AgentBase):
    "Goes from waypoint to waypoint; its first action comes after a look at everything."

    def __init__(self, target_path, **kwargs):
        super().__init__(target_path, **kwargs)
        self.way, self.waited = [(np.array(q), force) for q, force in WAY], 0
        print(open(target_path).read())

    def draw_action(self, observation):
        if not self.waited:
            print({{name: value.shape for name, value in observation.items()}})
        q, (target, force) = observation["joints_state"][:7], self.way[0]
        self.waited = self.waited + 1 if np.abs(q - target).max() < 0.02 else 1
        if self.waited > 5 and len(self.way) > 1:
            self.way.pop(0)
        self.is_success = len(self.way) == 1 and self.waited > 5
        return np.append(target, force), self.is_success
"""


def waypoints() -> list[tuple[list[float], float]]:
    """Joint positions and forces that carry the task's box to its goal, from above."""
    spec = load_robot("panda")
    model, rng, q = robot_model(spec), np.random.default_rng(0), np.array(spec.home)
    way = []
    for y, z, force in ((0.1, 0.2, 30), (0.1, 0.03, 30), (0.1, 0.03, -30), (0.1, 0.2, -30), (-0.1, 0.2, -30),
                        (-0.1, 0.032, -30), (-0.1, 0.032, 30), (-0.1, 0.2, 30)):  # fmt: skip
        T = np.diag([1.0, -1.0, -1.0, 1.0])
        T[:3, 3] = 0.0, y, z
        q = next(inverse(model, T, rng, near=q, count=1))
        way.append(([float(value) for value in q], float(force)))
    return way


def test_an_agent_carries_a_box_to_its_goal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run, log = run_tiny(tmp_path, "agent_builder.py", AGENT.format(way=waypoints()))
    assert run["ede_m"] < 0.02 and run["grasps_succeeded"] == run["grasps_attempted"] == 1, (run, log)
    assert '"red":\n- [0.0, -0.1, 0.03' in log and "'joints_state': (18,)" in log
    assert "'fix_camera_depth_image': (720, 1280)" in log and "'in_hand_camera_rgb_image': (720, 1280, 3)" in log


class Scripted(AgentBase):
    """Gives what it is told to, then has finished."""

    script: tuple[Any, ...] = ()

    def __init__(self, target_path: str, **settings: Any) -> None:
        super().__init__(target_path, **settings)
        self.rest, self.settings, self.seen = list(self.script), settings, 0

    def draw_action(self, observation: Any) -> Any:
        action = self.rest.pop(0)
        return (np.array(action), not self.rest) if isinstance(action, list) else action


def _run(folder: Path, *script: Any, **options: Any) -> FakeRobot:
    robot = FakeRobot()
    agent = type("Agent", (Scripted,), {"script": script})
    Agent2024.of(agent, **options)().run(goal_of(np.eye(4), folder), robot.typed)
    return robot


def test_motions_keep_to_speed_and_range_and_pictures_are_taken_when_looked_at(tmp_path: Path) -> None:
    robot = _run(tmp_path, [0.1] * 7 + [0.0], [9.0] * 7 + [0.0], [9.0] * 7 + [0.0])
    ends = [told[1][-1] for told in robot.told if told[0] == "follow"]
    assert np.allclose(ends, np.array([[0.1] * 7, [0.3] * 7, [0.5] * 7]))
    assert not [told for told in robot.told if told[0] == "frame"]
    robot.q[:] = 1.95
    assert _run(tmp_path, [0.0] * 8).told == [("wait", 0.1)]


def test_an_observation_takes_each_picture_once() -> None:
    robot = FakeRobot()
    observation = Observation(robot.typed, np.arange(18.0))
    first, again = observation.copy(), observation.copy()
    assert list(first) == ["joints_state", *IMAGES] and len(observation) == 5
    assert [told for told in robot.told if told[0] == "frame"] == [("frame", "kinect"), ("frame", "realsense")]
    first["fix_camera_depth_image"][:] = 9
    first["joints_state"][:] = 9
    assert again["fix_camera_depth_image"][1, 2] == observation["fix_camera_depth_image"][1, 2] == 2.0
    assert observation["joints_state"][17] == 17
    with pytest.raises(KeyError, match=r"an observation has joints_state, .*, and no 'poses'"):
        observation["poses"]


def test_the_gripper_is_told_once_a_change(tmp_path: Path) -> None:
    robot = _run(tmp_path, *([0.0] * 7 + [force] for force in (0, -30, -20, 0, -30, 50, 50)))
    assert [told[1:] for told in robot.told if told[0] == "gripper"] == [(0.0, 30.0), (0.08, 50.0)]


@pytest.mark.parametrize(
    "answer", [None, np.zeros(8), ([0.0] * 7, False), ([np.nan] * 8, True), (["x"] * 8, True), (np.zeros((8, 8)), 0)]
)
def test_what_is_no_action_is_refused_in_a_sentence(tmp_path: Path, answer: Any) -> None:
    with pytest.raises(ValueError, match=r"draw_action is to return \(8 finite numbers"):
        _run(tmp_path, answer)


def test_steps_end_and_settings_arrive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made: list[Any] = []

    class Endless(AgentBase):
        def __init__(self, target_path: str, **settings: Any) -> None:
            super().__init__(target_path, **settings)
            made.append(settings)

    robot = FakeRobot()
    solution = Agent2024.of(Endless, steps=3, camera_width=640)
    solution().run(goal_of(np.eye(4), tmp_path), robot.typed)
    assert made == [{"camera_width": 640}] and robot.told == [("wait", 0.1)] * 3
    assert "3 actions are used up" in capsys.readouterr().out


@given(st.tuples(*[st.floats(-3, 3)] * 6))
def test_targets_are_roll_pitch_yaw_about_fixed_axes(values: tuple[float, ...]) -> None:
    pose = np.eye(4)
    pose[:3, 3], pose[:3, :3] = values[:3], Rotation.from_euler("xyz", values[3:]).as_matrix()
    found = xyzrpy(pose)
    assert tuple(found[:3]) == values[:3]
    assert np.allclose(Rotation.from_euler("xyz", found[3:]).as_matrix(), pose[:3, :3], atol=1e-6)


def test_targets_lie_beside_models(tmp_path: Path) -> None:
    file = write_targets(goal_of(np.eye(4), tmp_path), tmp_path / "made")
    assert file.name == "tiny-1.yaml"
    assert parse_document(file.read_text(), "targets").value == {"a b": (((0.0,) * 6),)}
    assert (file.parents[1] / "models" / "a-b" / "collision.obj").read_text() == "v 0 0 0\n"
    with pytest.raises(ValueError, match="no object has a goal pose"):
        write_targets(goal_of(None, tmp_path), tmp_path / "other")


@pytest.mark.parametrize(
    ("code", "wrapped"),
    [
        ("class MyAgent:\n    def draw_action(self, observation): ...", True),
        ("class Solution:\n    def draw_action(self, observation): ...", True),
        (
            "class Solution:\n    def run(self, goal, robot): ...\nclass MyAgent:\n    def draw_action(self, o): ...",
            False,
        ),
    ],
)
def test_agents_are_recognised(tmp_path: Path, code: str, wrapped: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.path", [*__import__("sys").path])
    name = f"entry_{abs(hash(code))}"
    (tmp_path / f"{name}.py").write_text(code)
    assert issubclass(load(tmp_path, name), Agent2024) == wrapped


def test_a_class_of_neither_kind_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.path", [*__import__("sys").path])
    (tmp_path / "entry_of_neither_kind.py").write_text("class MyAgent: ...")
    with pytest.raises(TypeError, match="no class Solution with run"):
        load(tmp_path, "entry_of_neither_kind")


@pytest.fixture
def nothing_of_2024() -> Iterator[None]:
    """No module of 2024 is loaded, before and after."""

    def forget() -> None:
        for name in [name for name in sys.modules if name.partition(".")[0] == "ocrtoc_env"]:
            del sys.modules[name]

    forget()
    yield
    forget()


@pytest.mark.parametrize("brings", [False, True])
def test_the_base_class_is_where_2024_has_it_unless_a_package_brings_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, nothing_of_2024: None, brings: bool
) -> None:
    monkeypatch.setattr("sys.path", [*sys.path])
    if brings:
        (tmp_path / "ocrtoc_env" / "src").mkdir(parents=True)
        (tmp_path / "ocrtoc_env" / "src" / "agent_base.py").write_text("class AgentBase:\n    own = True\n")
    name = f"agent_builder_{brings}"
    (tmp_path / f"{name}.py").write_text(
        "from ocrtoc_env.src.agent_base import AgentBase\n\n\n"
        "class MyAgent(AgentBase):\n    def draw_action(self, observation): ...\n"
    )
    found = load(tmp_path, name)
    assert issubclass(found, Agent2024)
    assert getattr(found.agent, "own", False) == brings and issubclass(found.agent, AgentBase) != brings


def test_an_action_without_whether_it_has_finished_is_counted(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not tuple of 8"):
        _run(tmp_path, (0.0,) * 8)
