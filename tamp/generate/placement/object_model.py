"""An object about to be placed: its geometry, the ways it rests, and its outlines from above."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.scenarios.library.model import Model
from tamp.task import Object, Pose
from tamp.world.geometry.convex_union import Solid, solid
from tamp.world.geometry.object_geometry import load_geometry, stable_poses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

LIKELY = 0.04
"""A resting pose that a body let go anyhow takes more rarely than this is too shaky to stand in."""
FOOT = 0.002
"""What is no higher than this above the lowest point belongs to the foot [m]."""


@dataclass(frozen=True, eq=False)
class Thing:
    """A model of a library and what its geometry says.

    Attributes:
        model: the model.
        solid: for collision queries.
        points: vertices of its hull in its frame, shape (n, 3) [m].
        resting: rotations, shape (3, 3), in which it rests; the first is upright, as it is used.
    """

    model: Model
    solid: Solid
    points: Matrix
    resting: tuple[Matrix, ...]

    @cached_property
    def radius(self) -> float:
        """Of the ball about its origin that holds it [m]."""
        return float(np.linalg.norm(self.points, axis=1).max())

    def tilt(self, up: Matrix, other: Matrix) -> float:
        """Angle between two directions that point up, in its own frame, over all turns in which it looks the same."""
        symmetry = self.model.symmetry
        turned = [_about(0, i * math.tau / symmetry.x) @ up for i in range(symmetry.x)]
        turned += [_about(1, i * math.tau / symmetry.y) @ up for i in range(1, symmetry.y)]
        return min(math.acos(float(np.clip(direction @ other, -1.0, 1.0))) for direction in turned)

    def outline(self, R: Matrix) -> Matrix:
        """Sides of its bounding box when turned by `R`, shape (3,) [m]."""
        size: Matrix = np.ptp(self.points @ R.T, axis=0)
        return size

    def foot(self, R: Matrix) -> Matrix:
        """Sides along x and y of what it stands on when turned by `R`, shape (2,) [m]."""
        points = self.points @ R.T
        size: Matrix = np.ptp(points[points[:, 2] < points[:, 2].min() + FOOT, :2], axis=0)
        return size

    def bottom(self, R: Matrix) -> float:
        """Height of its lowest point over its origin when turned by `R` [m]; negative."""
        return float((self.points @ R[2]).min())

    def object(self, name: str, pose: Pose) -> Object:
        """An object of a task."""
        model = self.model
        return Object(name, model.shape, pose, None, model.mass, model.friction, model.symmetry, model.category)


@lru_cache(maxsize=512)
def thing(model: Model) -> Thing:
    """What the geometry of a model says; read once.

    Raises:
        TaskError: where the model's mesh cannot be used.
    """
    geometry = load_geometry(model.shape)
    found = stable_poses(geometry)
    upright = max(found, key=lambda pose: (round(float(pose.R[2, 2]), 3), pose.probability))
    others = [pose.R for pose in found if pose is not upright and pose.probability >= LIKELY]
    return Thing(model, solid(geometry.parts), geometry.hull.vertices, (upright.R, *others))


def _about(axis: int, angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[i, i] = turn[j, j] = c
    turn[i, j], turn[j, i] = -s, s
    return turn


def yawed(R: Matrix, yaw: float) -> Matrix:
    """A rotation turned further about the vertical."""
    turned: Matrix = _about(2, yaw) @ R
    return turned


def transform(R: Matrix, xyz: tuple[float, float, float]) -> Matrix:
    """A homogeneous transform, shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, xyz
    return T
