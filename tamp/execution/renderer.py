"""What pictures ask of a physics engine: bodies that stand where they are put, and a camera; nothing moves by itself.

A renderer's class is called with the items and the robot, `Renderer(items, robot)`, where `robot` is a
tamp.task.RobotSpec or None. It raises TaskError where an item's mesh cannot be used, and RobotError where the robot
cannot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
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


@dataclass(frozen=True)
class TexturedMesh:
    """A mesh that stands still.

    Attributes:
        path: an OBJ file with texture coordinates.
        texture: a picture.
        pose: where it stands (world frame).
    """

    path: Path
    texture: Path
    pose: Pose


@dataclass(frozen=True, eq=False)
class Lens:
    """How a picture of meshes is taken.

    Attributes:
        width, height: of the picture [pixels].
        view, projection: OpenGL's matrices, shape (4, 4).
        light: direction to a distant lamp, a unit vector (world frame).
        ambient: share of the light that comes from everywhere.
    """

    width: int
    height: int
    view: NDArray[np.float64]
    projection: NDArray[np.float64]
    light: Vector3
    ambient: float


@dataclass(frozen=True, eq=False)
class Raster:
    """A picture of meshes, arrays of shape (height, width).

    Attributes:
        color: shape (height, width, 3), red, green, blue in 0..255.
        buffer: OpenGL's depth buffer, 0 at the near plane and 1 at the far one.
        meshes: the place of the mesh that each pixel shows, -1 for none.
    """

    color: Image
    buffer: NDArray[np.float64]
    meshes: NDArray[np.int16]


class Rasterizer(Protocol):
    """Textured meshes to take pictures of; its class is called with them, `Rasterizer(meshes)`."""

    def picture(self, lens: Lens) -> Raster:
        """One picture of all meshes."""

    def close(self) -> None:
        """Free the meshes; every later call fails."""
