"""What pictures ask of a physics engine: bodies that stand where they are put, and a camera; nothing moves by itself.

A renderer's class is called with the items and the robot, `Renderer(items, robot)`, where `robot` is a
tamp.task.RobotSpec or None. It raises TaskError where an item's mesh cannot be used, and RobotError where the robot
cannot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from tamp.task.model import Shape
from tamp.task.pose import Pose, Vector3

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Image = NDArray[np.uint8]

Color = tuple[float, float, float, float]


@dataclass(frozen=True)
class Item:
    """A body in a picture.

    Attributes:
        shape: its geometry.
        color: red, green, blue, opacity in 0..1.
        pose: where it stands at first (world frame).
    """

    shape: Shape
    color: Color
    pose: Pose


@dataclass(frozen=True)
class View:
    """How a picture is taken, z up.

    Attributes:
        eye, target: where the camera stands, and what it looks at (world frame) [m].
        field_of_view: vertical [rad].
        width, height: of the picture [pixels].
    """

    eye: Vector3
    target: Vector3
    field_of_view: float
    width: int
    height: int


class Renderer(Protocol):
    """A scene to take pictures of."""

    def place(self, item: int, pose: Pose) -> None:
        """Put an item, by its place among the items, at a pose (world frame)."""

    def set_robot(self, q: Sequence[float], opening: float) -> None:
        """Put the arm at `q` [rad] and the fingers `opening` [m] apart; nothing happens where there is no robot."""

    def picture(self, view: View) -> Image:
        """The scene, shape (height, width, 3), red, green, blue in 0..255."""

    def close(self) -> None:
        """Free the scene; every later call fails."""
