"""EDE, the error of the OCRTOC paper, Algorithm 1 (Liu et al., "OCRTOC", IEEE Robotics and Automation Letters, 2022).

Per object, c = (L + W + H) / 3 of its model's bounding box. EDE is the mean distance between the eight vertices of the
model-aligned cube of edge c, centred at the model's origin, in the solution and the goal pose. UEB = 5 c bounds it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import bounds

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.model import Shape
    from tamp.task.pose import Pose

UEB_FACTOR = 5.0

CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
"""The vertices of a cube of edge 1."""


def mean_edge(shape: Shape) -> float:
    """Mean edge c of the shape's bounding box in its own frame [m]."""
    lower, upper = bounds(shape)
    return float(np.mean(upper - lower))


def upper_error_bound(shape: Shape) -> float:
    """UEB [m]: no object counts for more."""
    return UEB_FACTOR * mean_edge(shape)


def ede(edge: float, solution: Pose, goal: Pose) -> float:
    """Mean distance of the vertices of a cube between two poses [m], not capped.

    Args:
        edge: the cube's edge [m].
        solution: where the object is.
        goal: where it should be.
    """
    return float(np.linalg.norm(_vertices(edge, solution) - _vertices(edge, goal), axis=1).mean())


def _vertices(edge: float, pose: Pose) -> NDArray[np.float64]:
    """World positions of the cube's vertices, shape (8, 3) [m]."""
    T = pose.matrix
    return edge * CORNERS @ T[:3, :3].T + T[:3, 3]
