"""The robot's single steps: following a trajectory, closing on an object, letting it go.

The gripper holds by friction alone: nothing is ever welded, moved by hand or put back.
"""

from __future__ import annotations

import numpy as np

from tamp.execution.monitor import deviation
from tamp.execution.record import Deviation, Kind
from tamp.execution.simulator import GRAVITY, STEP, Simulator
from tamp.execution.tracking import set_points
from tamp.task import Attachment, Grip, Move, Pose, Release

ARRIVED = 0.002
"""Joint error at which a motion counts as finished [rad]."""

FALL_S = 2.0
"""How long an object may take to fall flat [s]."""

FLICKER_S = 0.05
"""A contact that is not there for less than this is none lost [s]."""

FALLEN = 0.02
"""Below this an object that fell counts as lying still [m/s], [rad/s]."""


class Operator:
    """Works the robot of a simulated world, and knows what it holds.

    Attributes:
        robot: the robot's body.
        held: what the fingers hold and where it should be in the tool frame, or None.
        tracking_error: largest joint error since it was last set to zero [rad].
    """

    def __init__(self, simulator: Simulator) -> None:
        if simulator.robot is None:
            raise ValueError("an operator needs a simulator with a robot")
        self._simulator = simulator
        self.robot = simulator.robot
        self.held: Attachment | None = None
        self.tracking_error = 0.0
        self._opening = simulator.robot.opening()

    def move(self, move: Move) -> None:
        """Follow a trajectory; empty fingers first go to their opening, a held object stays squeezed."""
        if self.held is None:
            self._open(move.opening)
        positions, velocities = set_points(move.trajectory, STEP)
        for q, v in zip(positions, velocities, strict=True):
            self.robot.command(q, v)
            self._simulator.step()
            # After the step the arm should be where the velocity was to take it.
            error = float(np.abs(self.robot.configuration() - (q + v * STEP)).max())
            self.tracking_error = max(self.tracking_error, error)
        end = move.trajectory.positions[-1]
        self.robot.command(end)
        self._simulator.wait(0.5, lambda: float(np.abs(self.robot.configuration() - end).max()) < ARRIVED, patience=6)

    def _open(self, opening: float) -> None:
        self.robot.open_to(opening)
        self._simulator.wait(1.5, lambda: abs(self.robot.opening() - opening) < 0.0005, patience=3)

    def grip(self, grip: Grip) -> Deviation | None:
        """Close the fingers and wait until they stand; the deviation of an object that is not between them then."""
        self._opening = self.robot.opening()
        body = self._simulator.bodies[grip.attachment.object]
        self.robot.squeeze(self.robot.spec.gripper.holding_force(body.mass * GRAVITY, body.friction))
        self._simulator.wait(2.0, lambda: self.robot.finger_speed() < 0.001, patience=24)
        self.held = grip.attachment
        return self.lost("missed")

    def release(self, release: Release) -> None:
        """Open the fingers and give the object a moment to come to rest."""
        self.held = None
        self._open(release.opening)
        self._simulator.step(round(0.15 / STEP))

    def await_fall(self, name: str) -> None:
        """Stand still until an object that was let go tilted has fallen and rests."""
        self._simulator.wait(FALL_S, lambda: max(self._simulator.speeds()[name]) < FALLEN, patience=24)

    def lost(self, kind: Kind = "dropped") -> Deviation | None:
        """Where the held object is not between the fingers: its deviation, and the hand is emptied of what hangs there.

        The fingers open as far as they were before they closed.
        """
        held = self.held
        if held is None or self._holds() or self._simulator.wait(FLICKER_S, self._holds, patience=1):
            return None
        self.held = None
        off = deviation(held.object, kind, held.T_tool_object, self.in_tool(held.object))
        self._open(self._opening)
        return off

    def _holds(self) -> bool:
        return self.held is not None and all(self.robot.touching(self._simulator.bodies[self.held.object].id))

    def in_tool(self, name: str) -> Pose:
        """Where an object stands in the tool frame."""
        return self.robot.tool().inverse() @ self._simulator.pose(name)
