"""What a robot with cameras offers a program that is told no poses.

Whatever offers this protocol can be worked by tamp.pipeline.perceived, a real robot as well as a simulated one.
"""

from __future__ import annotations

from typing import Protocol

from tamp.perception.cameras.camera import Camera, Frame
from tamp.task import RobotSpec, Trajectory


class Workcell(Protocol):
    """An arm, a gripper and cameras. Nothing in it says where an object is."""

    @property
    def robot(self) -> RobotSpec:
        """The robot as data."""

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The cameras as data, and from where those on the arm look."""

    @property
    def time(self) -> float:
        """Time that has passed in the cell [s]."""

    def frame(self, camera: str) -> Frame:
        """A picture by the camera of a name, from where it is now."""

    def configuration(self) -> tuple[float, ...]:
        """Where the arm's joints are now [rad]."""

    def opening(self) -> float:
        """Distance between the finger pads now [m]."""

    def follow(self, trajectory: Trajectory) -> None:
        """Move the arm along a trajectory and wait until it has arrived; the fingers do what they were told last."""

    def open_to(self, opening: float) -> None:
        """Send the fingers to an opening [m] and wait until they are there."""

    def squeeze(self, force: float) -> None:
        """Close the fingers, each with a force [N], wait until they stand, and keep pressing."""

    def wait(self, seconds: float) -> None:
        """Stand still for a time [s]."""
