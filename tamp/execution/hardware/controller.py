"""What carrying out a plan asks of a real robot's controller: whole motions, and a hand that opens, closes and feels.

Whatever offers this protocol is a controller, wherever it comes from. Its class is called with the robot, a
tamp.task.RobotSpec. Each method returns when what it asks for is done, and raises ControllerError where it cannot be
done; nothing is then asked any more.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Protocol, cast

from tamp.errors import TampError
from tamp.task import RobotSpec, Trajectory

DRY_RUN = "dry-run"
"""The controller that comes along: it moves nothing."""


class ControllerError(TampError):
    """A controller could not do what it was asked for."""


class Controller(Protocol):
    """A robot one seam higher than in a simulator: what it follows are motions, not set points."""

    def configuration(self) -> Sequence[float]:
        """Arm joint positions as they are measured, in the order of the robot's joints [rad]."""

    def opening(self) -> float:
        """Distance between the finger pads as it is measured [m]."""

    def follow(self, trajectory: Trajectory, opening: float) -> None:
        """Move the arm along a cubic Hermite curve on its own clock, fingers at `opening` [m] or holding something."""

    def open_to(self, opening: float) -> None:
        """Send the fingers to a distance between the pads [m]."""

    def grip(self, force: float) -> None:
        """Close the fingers until they stand, and go on pressing with `force` [N] each."""

    def holds(self) -> bool:
        """Whether the fingers hold something."""

    def wait(self, seconds: float) -> None:
        """Stand still, as while something falls [s]."""


def make_controller(name: str, robot: RobotSpec) -> Controller:
    """A controller by its name, "dry-run", or by the address of its class, "package.module:Class".

    Raises:
        TampError: where there is none.
    """
    address = "tamp.execution.hardware.dry_run:DryRun" if name == DRY_RUN else name
    module, _, attribute = address.partition(":")
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        valid = f'valid are {DRY_RUN} and "package.module:Class"'
        raise TampError(f"controller {name!r} cannot be loaded: {error}; {valid}") from error
    if not callable(found):
        raise TampError(f"controller {name!r} cannot be called; it must be a class, or a function that makes one")
    return cast("Controller", found(robot))
