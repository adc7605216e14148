"""A robot that only remembers what it was asked, and a task for solutions of other contests."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tamp.cli import main
from tamp.contest.api.client import ArmState, Frame, Goal, GoalObject, Refused, Robot
from tamp.contest.sandbox.choice import KINDS

TASK = """\
name: tiny
objects:
  - {name: red, shape: {box: [0.04, 0.04, 0.06]}, pose: {xyz: [0.0, 0.1, 0.03]}, goal: {pose: {xyz: [0.0, -0.1, 0.03]}}}
"""


def run_tiny(folder: Path, name: str, code: str) -> tuple[dict[str, Any], str]:
    """What `tamp contest run` makes of a solution on the tiny task: the record of its run, and its log."""
    pytest.importorskip("embreex", reason="cameras see by ray casting, which needs the extra 'perception'")
    (folder / "tiny.yaml").write_text(TASK)
    (folder / name).write_text(code)
    arguments = ["contest", "run", str(folder / name), "--tasks", str(folder / "tiny.yaml")]
    insist = [] if any(not kind().missing() for kind in KINDS) else ["--no-isolation"]
    assert main([*arguments, "--runs", "1", *insist, "-o", str(folder / "out")]) == 0
    log = (folder / "out" / "tiny-pybullet-0.log").read_text()
    (run,) = json.loads((folder / "out" / "results.json").read_text())["runs"]
    assert run["settings"] == {"ended": "finished"}, log
    return run, log


class FakeRobot:
    """Is at once where it is told to be; `told` has all calls."""

    def __init__(self) -> None:
        self.told: list[Any] = []
        self.q, self.width, self.time_left = np.zeros(7), 0.08, 600.0
        self.camera = SimpleNamespace(names=("kinect", "realsense"), frame=self._frame)
        self.arm = SimpleNamespace(
            joints=[f"joint{i}" for i in range(7)],
            lower=np.full(7, -2.0),
            upper=np.full(7, 2.0),
            velocity=np.full(7, 2.0),
            state=lambda: ArmState(self.q.copy(), np.eye(4), self.width),
            follow=self._follow,
            move_joints=lambda q, speed: self.told.append(("joints", list(q))),
            move_pose=lambda T, speed, straight: self.told.append(("pose", T)),
        )
        self.gripper = SimpleNamespace(stroke=0.08, go_to=self._go_to)

    @property
    def typed(self) -> Robot:
        return cast("Robot", self)

    def wait(self, seconds: float) -> None:
        self.told.append(("wait", seconds))
        self.time_left -= seconds

    def tf(self, parent: str, child: str) -> Any:
        if child not in ("kinect", "realsense", "panda_link8", "tool", "world"):
            raise Refused(f"there is no frame {child!r}")
        T = np.eye(4)
        T[2, 3] = 0.1 if child == "tool" else 0.0
        return T

    def _follow(self, times: Any, positions: Any, velocities: Any) -> None:
        self.told.append(("follow", np.array(positions)))
        self.q = np.array(positions[-1])

    def _go_to(self, width: float, effort: float) -> None:
        self.told.append(("gripper", width, effort))
        self.width = width
        self.time_left -= 0.5

    def _frame(self, name: str) -> Frame:
        self.told.append(("frame", name))
        depth = np.zeros((4, 6), dtype=np.float32)
        depth[1, 2] = 2.0
        K = np.array([[10.0, 0, 3.0], [0, 10.0, 2.0], [0, 0, 1]])
        return Frame(np.full((4, 6, 3), 7, dtype=np.uint8), depth, np.zeros((4, 6), dtype=bool), K, np.eye(4))


def goal_of(pose: Any, folder: Path) -> Goal:
    """A goal of one object called "a b", with that pose."""
    mesh = folder / "collision.obj"
    mesh.write_text("v 0 0 0\n")
    thing = GoalObject("a b", mesh, None, 0.1, 0.5, pose, None, None)
    return Goal("tiny: 1", {"a b": thing}, (0.0, 0.0, 1.0, 1.0, 0.02))
