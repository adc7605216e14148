"""A solution of an agent class as OCRTOC 2024 has it.

There, an agent is made with the path of a file of target poses and the settings of a configuration file. Ten times a
second it is given an observation and returns an action and whether it has finished, up to 6,000 times:

    class MyAgent(AgentBase):
        def draw_action(self, observation):
            q = observation["joints_state"][:7]
            return np.append(q, 30.0), False  # joint positions [rad], force that opens the gripper [N]; not finished

What is bridged, and what is not, stands in docs/guides/ocrtoc_solutions.md.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.contest.api.client import Goal, Robot

    Array = NDArray[np.float64]

STEP_S = 0.1
"""Between two actions [s]."""

STEPS = 6000
"""Actions at most."""

STILL = 1e-4
"""A target nearer than this is held, not moved to [rad]."""

IMAGES: Mapping[str, tuple[int, str]] = MappingProxyType(
    {
        "fix_camera_rgb_image": (0, "color"),
        "fix_camera_depth_image": (0, "depth"),
        "in_hand_camera_rgb_image": (-1, "color"),
        "in_hand_camera_depth_image": (-1, "depth"),
    }
)
"""Name in an observation -> which of the cell's cameras, and what of its frame."""

JOINTS = "joints_state"

HOME = "ocrtoc_env.src.agent_base"
"""The module that agents of 2024 import `AgentBase` from."""


class AgentBase:
    """What agents are derived from; stays where it is, and never finishes.

    Attributes:
        target_path: the file of target poses.
        is_success: returned with each action; true ends the run.
    """

    def __init__(self, target_path: str, **settings: Any) -> None:
        self.target_path, self.is_success = target_path, False

    def draw_action(self, observation: Mapping[str, Any]) -> tuple[Any, bool]:
        """The action: joint positions [rad], then the gripper's force [N]; and whether all is done."""
        return np.append(observation[JOINTS][:7], 0.0), self.is_success


def offer() -> None:
    """Let `AgentBase` be imported by the name that 2024 has for it, so that agents run as they were written."""
    names = HOME.split(".")
    for depth in range(1, len(names) + 1):
        module = sys.modules.setdefault(".".join(names[:depth]), ModuleType(".".join(names[:depth])))
        module.__path__ = []
    setattr(sys.modules[HOME], AgentBase.__name__, AgentBase)


class Observation(Mapping[str, "NDArray[Any]"]):
    """What an agent is given: the state of the joints, and images, which are taken when they are first looked at.

    Nothing moves between the action before and the one that follows, so that it does not matter when they are taken;
    an agent that looks at none does not wait for them.
    """

    def __init__(self, robot: Robot, joints: Array) -> None:
        self._robot, self._joints = robot, joints
        self._frames: dict[str, Any] = {}

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name == JOINTS:
            return self._joints.copy()
        if name not in IMAGES:
            raise KeyError(f"an observation has {', '.join(self)}, and no {name!r}")
        which, what = IMAGES[name]
        camera = self._robot.camera.names[which]
        if camera not in self._frames:
            self._frames[camera] = self._robot.camera.frame(camera)
        image: NDArray[Any] = getattr(self._frames[camera], what)
        return image.copy()

    def copy(self) -> dict[str, NDArray[Any]]:
        """All of it, as a dictionary."""
        return dict(self)

    def __iter__(self) -> Iterator[str]:
        return iter((JOINTS, *IMAGES))

    def __len__(self) -> int:
        return 1 + len(IMAGES)


class Agent2024:
    """Runs an agent step by step; `Agent2024.of(MyAgent)` is the class of such a solution."""

    agent: Callable[..., Any] = AgentBase
    settings: Mapping[str, Any] = MappingProxyType({})
    steps: int = STEPS

    @classmethod
    def of(cls, agent: Callable[..., Any], *, steps: int = STEPS, **settings: Any) -> type[Agent2024]:
        """A solution.

        Args:
            agent: the agent's class.
            steps: actions at most.
            settings: what the agent is made with beside the path of its targets, such as that of agent_config.yml.
        """
        made = {"agent": staticmethod(agent), "settings": MappingProxyType(settings), "steps": steps}
        return type("Solution", (cls,), made)

    def run(self, goal: Goal, robot: Robot) -> None:
        """Ask the agent for action after action until it says that it has finished.

        Raises:
            ValueError: where it returns something else than an action and whether it has finished.
        """
        with tempfile.TemporaryDirectory() as folder:
            agent = self.agent(str(write_targets(goal, Path(folder))), **self.settings)
            arm = _Arm(robot)
            for _ in range(self.steps):
                action, finished = checked(agent.draw_action(Observation(robot, arm.joints)), len(robot.arm.joints))
                arm.act(action)
                if finished:
                    return
        print(f"{self.steps} actions are used up")


class _Arm:
    """Carries actions out: joint positions within a step, and the gripper, where it changes its mind."""

    def __init__(self, robot: Robot) -> None:
        self._robot, self._sense = robot, 0
        self._q, self._finger = self._read()
        self.joints = self._state(self._q, self._finger)

    def act(self, action: Array) -> None:
        """Move towards the joint positions for a step, as far as the joints' speed allows; open or close."""
        arm = self._robot.arm
        most = arm.velocity * STEP_S
        target = np.clip(self._q + np.clip(action[:-1] - self._q, -most, most), arm.lower, arm.upper)
        change = target - self._q
        if np.abs(change).max() < STILL:
            self._robot.wait(STEP_S)
        else:
            speed = change / STEP_S
            arm.follow([0.0, STEP_S], [self._q, target], [speed, speed])
        sense = int(np.sign(action[-1]))
        if sense not in (0, self._sense):  # each closing is an attempt to grasp: not to be repeated at every step
            width = self._robot.gripper.stroke if sense > 0 else 0.0
            self._robot.gripper.go_to(width, effort=min(abs(float(action[-1])), 1000.0))
            self._sense = sense
        q, finger = self._read()
        self.joints = self._state(q, finger)
        self._q, self._finger = q, finger

    def _read(self) -> tuple[Array, float]:
        state = self._robot.arm.state()
        return state.q, state.width / 2

    def _state(self, q: Array, finger: float) -> Array:
        """Positions of arm and fingers, then their mean speeds over the last step."""
        speed = (finger - self._finger) / STEP_S
        return np.concatenate([q, [finger, finger], (q - self._q) / STEP_S, [speed, speed]])


def checked(answer: Any, joints: int) -> tuple[Array, bool]:
    """What `draw_action` returned: an action of so many joints and the gripper, and whether the agent has finished.

    Raises:
        ValueError: where it is something else.
    """
    wanted = f"draw_action is to return ({joints + 1} finite numbers, whether it has finished)"
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        many = f" of {len(answer)}" if isinstance(answer, (tuple, list)) else ""
        raise ValueError(f"{wanted}, not {type(answer).__name__}{many}")
    try:
        action = np.array(answer[0], dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{wanted}; its action is {type(answer[0]).__name__}") from None
    if action.shape != (joints + 1,) or not np.isfinite(action).all():
        raise ValueError(f"{wanted}; its action has shape {action.shape}, or holds what is not finite")
    return action, bool(answer[1])


def write_targets(goal: Goal, folder: Path) -> Path:
    """Write what is asked as 2024 does: targets/TASK.yaml, beside models/NAME with the mesh of each object.

    The file has a key an object and a list of one target pose: x, y, z [m], roll, pitch, yaw [rad], world frame.

    Returns:
        The path of the file.

    Raises:
        ValueError: where no object has a goal pose; 2024's language is not bridged.
    """
    poses = {name: thing.pose for name, thing in goal.objects.items() if thing.pose is not None}
    if not poses:
        raise ValueError(f"{goal.task}: no object has a goal pose; an agent of 2024 is told poses only")
    for name, thing in goal.objects.items():
        place = folder / "models" / _plain(name)
        place.mkdir(parents=True)
        for mesh in (thing.mesh, thing.visual):
            if mesh is not None:
                (place / mesh.name).symlink_to(mesh)
    file = folder / "targets" / f"{_plain(goal.task)}.yaml"
    file.parent.mkdir()
    lines = [f"{json.dumps(name)}:\n- {json.dumps(xyzrpy(pose))}\n" for name, pose in poses.items()]
    file.write_text("".join(lines), encoding="utf-8")
    return file


def xyzrpy(pose: Array) -> list[float]:
    """Position and roll, pitch, yaw (about fixed axes, roll first) of a pose (4, 4)."""
    flat = float(np.clip(-pose[2, 0], -1.0, 1.0))
    if abs(flat) > 1 - 1e-12:  # roll and yaw turn about one axis: all of it is called roll
        roll, yaw = np.arctan2(-pose[1, 2], pose[1, 1]), 0.0
    else:
        roll, yaw = np.arctan2(pose[2, 1], pose[2, 2]), np.arctan2(pose[1, 0], pose[0, 0])
    return [float(value) for value in (*pose[:3, 3], roll, np.arcsin(flat), yaw)]


def _plain(name: str) -> str:
    """A name that a file may have."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "-", name).lstrip(".") or "unnamed"
