"""The error as OCRTOC 2020's own program computed it: a cube twice as large as the paper's, and symmetry forgiven.

The cube's edge is 2 c. An object that looks the same after n turns about an axis is scored by the turn that suits it
best; where any turn will do, by the two ends of that axis within its bounding box instead of the cube. The bound is the
paper's. Source: the pose error in OCRTOC's evaluation of 2020, and the column `metric` of its objects.csv.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from tamp.scoring.ede import CORNERS, mean_edge
from tamp.task.mesh.parts import bounds
from tamp.task.model import ANY_TURN

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.model import Object, Shape, Symmetry
    from tamp.task.pose import Pose

    Array = NDArray[np.float64]


def symmetric_error(thing: Object, solution: Pose, goal: Pose) -> float:
    """Mean distance of the object's reference points between two poses, the best of its symmetric turns [m]."""
    points = _reference_points(thing.shape, thing.symmetry)
    T_solution, T_goal = solution.matrix, goal.matrix
    reached = points @ T_solution[:3, :3].T + T_solution[:3, 3]
    turned = np.einsum("rij,pj->rpi", _turns(thing.symmetry), points)
    meant = turned @ T_goal[:3, :3].T + T_goal[:3, 3]
    return float(np.linalg.norm(reached - meant, axis=2).mean(axis=1).min())


def _reference_points(shape: Shape, symmetry: Symmetry) -> Array:
    """The cube's vertices; with one axis of any turn its two ends, with more of them the origin. Shape (n, 3) [m]."""
    free = [i for i, fold in enumerate((symmetry.x, symmetry.y, symmetry.z)) if fold == ANY_TURN]
    if not free:
        return 2 * mean_edge(shape) * CORNERS
    if len(free) > 1:
        return np.zeros((1, 3))
    ends = np.zeros((2, 3))
    lower, upper = bounds(shape)
    ends[:, free[0]] = lower[free[0]], upper[free[0]]
    return ends


@lru_cache(maxsize=256)
def _turns(symmetry: Symmetry) -> Array:
    """Every product of the turns about x, y and z that the symmetry allows, none at all first; shape (n, 3, 3)."""
    folds = (1 if fold == ANY_TURN else fold for fold in (symmetry.x, symmetry.y, symmetry.z))
    about = [[_turn(axis, 2 * np.pi * k / fold) for k in range(fold)] for axis, fold in enumerate(folds)]
    return np.array([x @ y @ z for x, y, z in product(*about)])


def _turn(axis: int, angle: float) -> Array:
    """Rotation about a coordinate axis, shape (3, 3)."""
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[[i, j], [i, j]] = np.cos(angle)
    turn[j, i] = np.sin(angle)
    turn[i, j] = -np.sin(angle)
    return turn
