"""Plans written by hand for tests: straight joint motions with a smooth time law, no search and no collision checks."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from tamp.task import Action, Attachment, Grip, Move, Plan, Pose, Release, Task, Trajectory, load_robot
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.robot.model import RobotModel, robot_model

DOWN = Pose.from_rpy((0, 0, 0), (np.pi, 0, 0))
OPEN = 0.08


def timed(path, speed=1.0):
    """Quintic time law along a cubic spline through the waypoints, shape (n, joints)."""
    path = np.asarray(path)
    lengths = np.r_[0, np.cumsum(np.maximum(np.linalg.norm(np.diff(path, axis=0), axis=1), 1e-9))]
    spline = CubicSpline(lengths, path) if len(path) > 2 else None
    duration = max(0.3, 1.9 * lengths[-1] / speed)
    t = np.linspace(0, duration, max(3, int(duration / 0.01)))
    u = t / duration
    s = lengths[-1] * (10 * u**3 - 15 * u**4 + 6 * u**5)
    ds = lengths[-1] * (30 * u**2 - 60 * u**3 + 30 * u**4) / duration
    if spline is None:
        direction = (path[1] - path[0]) / lengths[-1]
        return Trajectory(t, path[0] + s[:, None] * direction, ds[:, None] * direction)
    return Trajectory(t, spline(s), spline(s, 1) * ds[:, None])


class HandPlanner:
    """Strings together pick and place actions, remembering where the arm is and where things are meant to be."""

    def __init__(self, task: Task, start: dict[str, Pose], q=None):
        self.task, self.start = task, dict(start)
        self.robot: RobotModel = robot_model(load_robot(task.robot))
        self.home = np.array(self.robot.home if q is None else q)
        self.q, self.rng = self.home.copy(), np.random.default_rng(0)
        self.actions: list[Action] = []
        self.held: Attachment | None = None
        self.width = OPEN

    def _ik(self, T, near):
        solutions = list(inverse(self.robot, T.matrix, self.rng, near=near, count=6))
        return min(solutions, key=lambda q: np.abs(q - near).max())

    def _move(self, phase, path, opening, held=None, speed=1.0):
        self.q = np.asarray(path)[-1]
        return Move(phase, timed(path, speed), opening, held)

    def _line(self, T):
        return straight_line(self.robot, self.q, T.matrix)

    def pick(self, name, T_object_tool, width, opening=OPEN, height=0.12, pose=None):
        T_world_tool = (pose or self.start[name]) @ T_object_tool
        above = Pose((0, 0, height)) @ T_world_tool
        self.held, self.width = Attachment(name, T_object_tool.inverse()), width
        q = self._ik(above, self.q)
        steps = [self._move("transit", [self.q, q], opening)]
        steps.append(self._move("approach", self._line(T_world_tool), opening, speed=0.6))
        steps.append(Grip(self.held, width))
        steps.append(self._move("lift", self._line(above), width, self.held, speed=0.6))
        self.actions.append(Action("pick", (name,), tuple(steps)))

    def place(self, pose, opening=OPEN, height=0.12, drop=0.001):
        T_world_tool = Pose((0, 0, drop)) @ pose @ self.held.T_tool_object.inverse()
        above = Pose((0, 0, height)) @ T_world_tool
        name = self.held.object
        q = self._ik(above, self.q)
        steps = [self._move("transfer", [self.q, q], self.width, self.held)]
        steps.append(self._move("lower", self._line(T_world_tool), self.width, self.held, speed=0.6))
        steps.append(Release(name, pose, opening))
        steps.append(self._move("retreat", self._line(above), opening, speed=0.6))
        self.held = None
        self.actions.append(Action("place", (name,), tuple(steps)))

    def plan(self) -> Plan:
        return Plan(self.task.name, self.task.robot, 0, self.start, tuple(self.home), {}, tuple(self.actions))
