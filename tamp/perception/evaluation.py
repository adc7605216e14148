"""How far estimates are from the truth: EDE as contests score it, and over the turns that leave a mesh as it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimate import Estimate
from tamp.perception.estimation.assignment import assigned
from tamp.perception.estimation.models.object_model import CUBE, ObjectModel, object_model
from tamp.perception.rendering.surface import Surface
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True)
class PoseError:
    """How wrong an estimate is.

    Attributes:
        symmetric: EDE to the nearest of the true poses that the mesh's symmetries make alike [m]; None: not seen.
        raw: EDE to the true pose [m]; None: not seen.
        confidence: the estimate's own.
        said: the name that the estimate goes by: of several objects of one mesh it may be another's.
    """

    symmetric: float | None
    raw: float | None
    confidence: float
    said: str


def pose_error(model: ObjectModel, estimate: Pose, truth: Pose) -> tuple[float, float]:
    """EDE over the mesh's symmetries, and raw [m] (OCRTOC paper, Algorithm 1, with a cube of the mesh's mean edge)."""
    cube = model.edge * CUBE
    T = truth.matrix
    corners = cube @ T[:3, :3].T + T[:3, 3]
    turned = estimate.matrix @ model.symmetries
    placed = np.einsum("nij,kj->nki", turned[:, :3, :3], cube) + turned[:, None, :3, 3]
    errors = np.linalg.norm(placed - corners, axis=2).mean(axis=1)
    return float(errors.min()), float(errors[0])


def pose_errors(
    estimates: Mapping[str, Estimate], truth: Mapping[str, Pose], objects: Mapping[str, Surface]
) -> dict[str, PoseError]:
    """Errors of all objects that are there; several of one mesh are matched with the truth as fits best in sum.

    Args:
        estimates: what a perceiver says; an object absent here counts as not seen.
        truth: object -> pose.
        objects: object -> mesh.
    """
    kinds: dict[int, list[str]] = {}
    for name in truth:
        kinds.setdefault(id(objects[name]), []).append(name)
    unseen = Estimate(None, 0.0)
    errors = {}
    for names in kinds.values():
        model = object_model(objects[names[0]])
        said = [estimates.get(name, unseen) for name in names]
        table = [[_error(model, e, truth[name]) for name in names] for e in said]
        cost = [[10.0 if error is None else error[0] for error in row] for row in table]
        for row, column in enumerate(assigned(np.array(cost))):
            error = table[row][column]
            symmetric, raw = (None, None) if error is None else error
            errors[names[column]] = PoseError(symmetric, raw, said[row].confidence, names[row])
    return {name: errors[name] for name in truth}


def _error(model: ObjectModel, estimate: Estimate, truth: Pose) -> tuple[float, float] | None:
    return None if estimate.pose is None else pose_error(model, estimate.pose, truth)
