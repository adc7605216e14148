"""A robot that stands at home in a simulator, closes its fingers and opens them, with nothing else there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tamp.execution.simulator import STEP, Robot, Simulator, wait
from tamp.execution.simulators import make_simulator
from tamp.task import RobotSpec

STANDS_S = 1.0
"""How long the arm is left to stand [s]."""

SINKS = 0.005
"""How far a joint may be off home then [rad or m]."""

MISSED = 0.002
"""How far the fingers may be from closed, and from their stroke [m]."""

MOVES_S = 2.0
"""How long they may take [s]."""


@dataclass(frozen=True)
class Standing:
    """What was seen.

    Attributes:
        joint: the one that is farthest off home.
        off: how far it is [rad or m].
        stroke: how far the fingers should open [m].
        shut, open: how far they did close and open [m].
    """

    joint: str
    off: float
    stroke: float
    shut: float
    open: float

    @property
    def complaint(self) -> str:
        """What is wrong; empty where nothing is."""
        if not self.off <= SINKS:
            sunk = f"{self.joint} is {self.off:.2g} off home after {STANDS_S:g} s"
            return f"{sunk}: are masses and effort limits right, and is home free?"
        if self.shut > MISSED or self.open < self.stroke - MISSED:
            went = f"the fingers close to {1000 * self.shut:.1f} and open to {1000 * self.open:.1f} mm"
            return f"{went}, not to 0 and {1000 * self.stroke:.1f}: what is in their way, or damps them in the URDF?"
        return ""

    def __str__(self) -> str:
        return self.complaint or f"stands at home within {self.off:.1g}, closes and opens"


def stand(simulator: str, spec: RobotSpec) -> Standing:
    """Let a robot stand at home in a simulator, and work its fingers.

    Args:
        simulator: its name.
        spec: the robot.

    Raises:
        RobotError: where the simulator cannot take it.
    """
    with make_simulator(simulator, (), robot=spec) as world:
        robot = world.robot
        assert robot is not None
        world.step(round(STANDS_S / STEP))
        off = np.abs(robot.configuration() - np.array(spec.home))
        shut, opened = (_moved(world, robot, opening) for opening in (0.0, spec.gripper.stroke))
    worst = int(off.argmax())
    return Standing(spec.joints[worst], float(off[worst]), spec.gripper.stroke, shut, opened)


def _moved(world: Simulator, robot: Robot, opening: float) -> float:
    """How far the fingers are open when they have been sent to an opening [m]."""
    robot.open_to(opening)
    wait(world, MOVES_S, lambda: abs(robot.opening() - opening) < MISSED)
    return robot.opening()
