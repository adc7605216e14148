"""A controller that moves nothing: it takes its own clock on by what each thing would take, and holds all to limits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tamp.execution.hardware.controller import ControllerError
from tamp.task import RobotSpec, Trajectory

FINGERS_M_S = 0.1
"""How fast the pads part or close [m/s]."""

SLACK = 1e-6
"""By which limits may be exceeded, as numbers are rounded: of a joint's limit."""

JUMP = 1e-3
"""How far a motion may begin from where the last one ended [rad]."""


class DryRun:
    """The robot as its data has it, at home and open, in a world in which every grip succeeds.

    Attributes:
        time: of its own clock, since it was made [s].
    """

    def __init__(self, robot: RobotSpec) -> None:
        self.time = 0.0
        self._robot = robot
        self._q = np.array(robot.home)
        self._opening, self._pressing = robot.gripper.stroke, False

    def configuration(self) -> Sequence[float]:
        """Where the last motion ended [rad]."""
        return tuple(float(q) for q in self._q)

    def opening(self) -> float:
        """Where the fingers were sent last [m]."""
        return self._opening

    def follow(self, trajectory: Trajectory, opening: float) -> None:
        """Let a motion pass that begins where the arm is and keeps the robot's limits."""
        jump = float(np.abs(trajectory.positions[0] - self._q).max())
        if not jump <= JUMP:
            raise ControllerError(
                f"a motion begins {jump:.4f} rad from where the arm stands; at most {JUMP:g} is valid"
            )
        for joint, name in enumerate(self._robot.joints):
            q, v = trajectory.positions[:, joint], trajectory.velocities[:, joint]
            if q.min() < self._robot.lower[joint] - SLACK or q.max() > self._robot.upper[joint] + SLACK:
                raise ControllerError(
                    f"a motion takes {name} to {q.min():.4f} and {q.max():.4f} rad, out of its limits"
                )
            if np.abs(v).max() > self._robot.velocity[joint] * (1 + SLACK):
                raise ControllerError(f"a motion takes {name} to {np.abs(v).max():.4f} rad/s, faster than its limit")
        self._opening, self._q = opening, trajectory.positions[-1].copy()
        self.time += trajectory.duration

    def open_to(self, opening: float) -> None:
        """Take the time that the fingers need."""
        stroke = self._robot.gripper.stroke
        if not -SLACK <= opening <= stroke + SLACK:
            raise ControllerError(f"the fingers open from 0 to {stroke:g} m, not to {opening:g}")
        self.time += abs(opening - self._opening) / FINGERS_M_S
        self._opening, self._pressing = opening, False

    def grip(self, force: float) -> None:
        """Take the time that the fingers need to close, whatever is between them."""
        if not 0.0 < force <= self._robot.gripper.force:
            raise ControllerError(f"the fingers press with up to {self._robot.gripper.force:g} N, not {force:g}")
        self.time += self._opening / FINGERS_M_S
        self._pressing = True

    def holds(self) -> bool:
        """Whether the fingers were told to close since they were told to open."""
        return self._pressing

    def wait(self, seconds: float) -> None:
        """Take the clock on."""
        self.time += seconds
