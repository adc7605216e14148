"""The robot's single steps: following a trajectory set point by set point, closing on an object, letting it go."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.log import Deviation, Kind
from tamp.execution.monitor import deviation
from tamp.execution.simulator import GRAVITY, ROBOT, STEP, Simulator, Touch, wait
from tamp.task import Attachment, Grip, Move, Pose, Release, Trajectory
from tamp.task.robot import GENTLE_FORCE
from tamp.world.kinematics.inverse import straight_line
from tamp.world.robot.model import robot_model

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def positions_at(trajectory: Trajectory, times: Array) -> Array:
    """Joint positions at `times` [s], shape (n, joints) [rad]: the cubic Hermite curve, at rest before and after."""
    knots, q, v = trajectory.times, trajectory.positions, trajectory.velocities
    if len(knots) == 1:
        return np.repeat(q, len(times), axis=0)
    times = np.clip(times, knots[0], knots[-1])
    i = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
    h = (knots[i + 1] - knots[i])[:, None]
    s = (times - knots[i])[:, None] / h
    rest = 1 - s
    return np.asarray(
        (1 + 2 * s) * rest**2 * q[i]
        + s * rest**2 * h * v[i]
        + s**2 * (3 - 2 * s) * q[i + 1]
        - s**2 * rest * h * v[i + 1]
    )


def set_points(trajectory: Trajectory, step: float) -> tuple[Array, Array]:
    """What to send to the motors before each step of `step` seconds, both of shape (n, joints).

    The position is where the arm should be now, the velocity [rad/s] what brings it to where it should be after the
    step. So the position term acts on real errors only; asking for the later position would make the arm lead.
    """
    count = max(1, math.ceil(trajectory.duration / step - 1e-9))
    q = positions_at(trajectory, np.arange(count + 1, dtype=np.float64) * step)
    return q[:-1], np.diff(q, axis=0) / step


def backwards(trajectory: Trajectory) -> Trajectory:
    """The same motion from its end to its start."""
    end = trajectory.times[-1]
    return Trajectory(end - trajectory.times[::-1], trajectory.positions[::-1], -trajectory.velocities[::-1])


ARRIVED = 0.002
"""Joint error at which a motion counts as finished [rad]."""

FALL_S = 2.0
"""How long an object may take to fall flat [s]."""

FLICKER_S = 0.05
"""A contact that is not there for less than this is none lost [s]."""

FALLEN = 0.02
"""Below this an object that fell counts as lying still [m/s], [rad/s]."""


GIVE, GIVES, GIVING = 0.0005, 8, 12
"""How far the arm gives way at a time to what one finger alone touches [m], how often, and for so many steps."""


ALONG = 0.1
"""Least share of the closing axis in the normals of touches that says to which side the arm should give way."""


def _off(touch: Touch, name: str) -> Array:
    """The direction from an object to what touches it (world frame)."""
    return np.array(touch.normal) * (1.0 if touch.b == name else -1.0)


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
        self._forces = GENTLE_FORCE, GENTLE_FORCE

    def move(self, move: Move) -> None:
        """Follow a trajectory; empty fingers first go to their opening, a held object stays squeezed."""
        if self.held is None:
            self.open(move.opening)
        self.follow(move.trajectory)

    def follow(self, trajectory: Trajectory) -> None:
        """Follow a trajectory set point by set point, and wait until the arm has arrived."""
        positions, velocities = set_points(trajectory, STEP)
        for q, v in zip(positions, velocities, strict=True):
            self.robot.command(q, v)
            self._simulator.step()
            # After the step the arm should be where the velocity was to take it.
            error = float(np.abs(self.robot.configuration() - (q + v * STEP)).max())
            self.tracking_error = max(self.tracking_error, error)
        end = trajectory.positions[-1]
        self.robot.command(end)
        wait(self._simulator, 0.5, lambda: float(np.abs(self.robot.configuration() - end).max()) < ARRIVED, patience=6)

    def open(self, opening: float) -> None:
        """Send the fingers to an opening [m] and wait until they are there."""
        self.robot.open_to(opening)
        wait(self._simulator, 1.5, lambda: abs(self.robot.opening() - opening) < 0.0005, patience=3)

    def grip(self, grip: Grip) -> Deviation | None:
        """Close the fingers and wait until they stand; the deviation of an object that is not between them then."""
        self._opening = self.robot.opening()
        item = self._simulator.objects[grip.attachment.object]
        self._forces = self.robot.spec.gripper.pressing(item.mass * GRAVITY, item.friction, grip.force)
        gentle, firm = self._forces
        self._press(gentle, 2.0, patience=24)
        for _ in range(GIVES):
            if not self._gives_way(item.name):
                break
            self._press(gentle, 0.5, patience=6)
        if firm > gentle:
            self._press(firm, 0.5, patience=6)
        self.held = grip.attachment
        return self.lost("missed")

    def _gives_way(self, name: str) -> bool:
        """Let the arm give way a little to what one finger alone touches and does not move; whether it had to.

        Fingers move together: else the other one never gets to what lies a millimetre beside the middle (Hsiao, Chitta,
        Ciocarlie and Jones, "Contact-Reactive Grasping of Objects with Partial Shape Information", IROS 2010).
        """
        feels = self.robot.touching(name)
        if all(feels) or not any(feels):
            return False
        tool, spec = self.robot.tool().matrix, self.robot.spec
        closing = tool[:3, :3] @ np.array(spec.gripper.axis)
        touches = [touch for touch in self._simulator.touches() if {touch.a, touch.b} == {ROBOT, name}]
        away = sum(float(_off(touch, name) @ closing) for touch in touches)
        aside = tool.copy()
        aside[:3, 3] += np.sign(away) * GIVE * closing
        told = abs(away) > ALONG
        path = straight_line(robot_model(spec), self.robot.configuration(), aside) if told else None
        if path is None:
            return False
        self.robot.command(path[-1])
        self._simulator.step(GIVING)
        return True

    def _press(self, force: float, limit_s: float, patience: int) -> None:
        """Press with a force [N] and wait until the fingers stand."""
        self.robot.squeeze(force)
        wait(self._simulator, limit_s, lambda: self.robot.finger_speed() < 0.001, patience=patience)

    def release(self, release: Release) -> None:
        """Open the fingers, which ease first what they press firmly, and give the object a moment to come to rest."""
        gentle, firm = self._forces
        if self.held is not None and firm > gentle:
            self._press(gentle, 0.5, patience=6)
        self.held = None
        self.open(release.opening)
        self._simulator.step(round(0.15 / STEP))

    def await_fall(self, name: str) -> None:
        """Stand still until an object that was let go tilted has fallen and rests."""
        wait(self._simulator, FALL_S, lambda: max(self._simulator.speeds()[name]) < FALLEN, patience=24)

    def lost(self, kind: Kind = "dropped") -> Deviation | None:
        """Where the held object is not between the fingers: its deviation, and the hand is emptied of what hangs there.

        The fingers open as far as they were before they closed.
        """
        held = self.held
        if held is None or self._holds() or wait(self._simulator, FLICKER_S, self._holds, patience=1):
            return None
        self.held = None
        off = deviation(held.object, kind, held.T_tool_object, self.in_tool(held.object))
        self.open(self._opening)
        return off

    def _holds(self) -> bool:
        return self.held is not None and all(self.robot.touching(self.held.object))

    def in_tool(self, name: str) -> Pose:
        """Where an object stands in the tool frame."""
        return self.robot.tool().inverse() @ self._simulator.pose(name)
