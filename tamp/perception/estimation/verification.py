"""The last word on who is where, and which way round: residuals tell shapes apart that differ by millimetres.

The joint choice forgives a few millimetres, since guesses err by that much. Here every candidate in a chosen place, of
the object that was chosen for it and of any other, is fitted to the place's own points; what fits best with everything
else is an assignment of objects to places (Kuhn, 1955).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.assignment import assigned
from tamp.perception.estimation.candidates import Candidate
from tamp.perception.estimation.fit import agreement, gaps, polished
from tamp.perception.estimation.fusion import VOXEL
from tamp.perception.estimation.models.object_model import ObjectModel
from tamp.perception.estimation.selection import Selection
from tamp.perception.estimation.turns.likeness import misfit
from tamp.perception.estimation.volume import Volume

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

VARIANTS = 8
"""Candidates of one object that are fitted in one place."""

POINTS = 2500
"""Points of a place, about, that candidates are fitted to; the one that is kept is fitted to all."""

APART = 0.02
"""Poses of an object that differ by less than this, over its symmetries, are the same [m]."""

CLAIMED = 0.5
"""A point that is explained better than this elsewhere may be another object's."""

NEVER = 1e9
"""The cost of an object in a place where it has no candidate."""


@dataclass(frozen=True, eq=False)
class Verified:
    """What is made of one object.

    Attributes:
        candidate: index of the candidate that the pose comes from.
        pose: T_world_object, shape (4, 4).
        own: indices of the measured points that belong to it.
        lead: how much worse the next best is that was fitted, turned round or another object in exchange, in the
            likelihood's logarithm a point; infinite where there is none.
    """

    candidate: int
    pose: Array
    own: NDArray[np.int64]
    lead: float


@dataclass(frozen=True, eq=False)
class _Fit:
    """An object fitted in a place: the best candidate's pose, its cost, and the least of clearly different ones."""

    candidate: int
    pose: Array
    cost: float
    second: float


def verify(
    scene: Volume, models: Sequence[ObjectModel], found: Sequence[Sequence[Candidate]], selection: Selection
) -> dict[int, Verified]:
    """Object -> what is made of it, for all that the selection has chosen a candidate for."""
    seen = [i for i, k in enumerate(selection.chosen) if k >= 0]
    rivals = [_rivals(models, selection, seen, place) for place in seen]
    off = np.array([gaps(scene.cloud, models[i], found[i][selection.chosen[i]].pose) for i in seen])
    owns = [
        _own(found, selection, place, some, off[column] > np.delete(off, column, axis=0).min(axis=0, initial=np.inf))
        for column, (place, some) in enumerate(zip(seen, rivals, strict=True))
    ]
    fits = {
        (row, column): _fitted(scene, models[i], [(k, found[i][k].pose) for k in some[i]], owns[column])
        for column, some in enumerate(rivals)
        for row, i in enumerate(seen)
        if i in some
    }
    costs = np.full((len(seen), len(seen)), NEVER)
    for at, fit in fits.items():
        costs[at] = fit.cost
    columns = assigned(costs)
    verified = {}
    for row, (i, column) in enumerate(zip(seen, columns, strict=True)):
        fit, own = fits[row, column], owns[column]
        # A pose that was fitted to all points would only drift where they leave it free.
        pose = polished(scene.cloud, models[i], fit.pose, own) if len(own) >= 2 * POINTS else fit.pose
        verified[i] = Verified(fit.candidate, pose, own, _lead(fits, costs, columns, row) / max(1, len(own)))
    return verified


def _rivals(
    models: Sequence[ObjectModel], selection: Selection, seen: Sequence[int], place: int
) -> dict[int, list[int]]:
    """Object -> its candidates in the place that was chosen for an object; others of the same mesh have none."""
    chosen = selection.chosen[place]
    center = selection.center(place, chosen)
    some = {i: selection.at(i, center)[:VARIANTS] for i in seen if models[i] is not models[place]}
    some[place] = [chosen, *(k for k in selection.at(place, center) if k != chosen)][:VARIANTS]
    return {i: candidates for i, candidates in some.items() if candidates}


def _own(
    found: Sequence[Sequence[Candidate]],
    selection: Selection,
    place: int,
    rivals: dict[int, list[int]],
    nearer: NDArray[np.bool_],
) -> NDArray[np.int64]:
    """The points of a place: those that any candidate there explains better than what is chosen elsewhere does.

    Of two surfaces that touch both explain the points: those that are `nearer` to what is chosen elsewhere are its own.
    """
    covered = selection.covered(without=(place,))
    best = np.zeros(len(covered))
    for i, some in rivals.items():
        for k in some:
            best[found[i][k].points] = np.maximum(best[found[i][k].points], found[i][k].weights)
    return np.flatnonzero((best > 0) & (best >= covered) & ~(nearer & (covered > CLAIMED)))


def _fitted(scene: Volume, model: ObjectModel, candidates: Sequence[tuple[int, Array]], own: NDArray[np.int64]) -> _Fit:
    """The best that an object can do in a place, of candidates that are numbered, with the points of the place."""
    some = own[:: max(1, len(own) // POINTS)]
    poses = np.stack([polished(scene.cloud, model, pose, some) for _, pose in candidates])
    seen_through = agreement(scene, model, poses, len(model.points)).violations * model.area / VOXEL**2
    misfits = np.array([misfit(scene.cloud, model, pose, some) for pose in poses])
    costs = seen_through + misfits * len(own) / max(1, len(some))
    best = int(costs.argmin())
    apart = np.array([model.apart(poses[best], pose) for pose in poses]) > APART
    # Candidates that come to the same pose are one: the first, which explained most before it was fitted.
    same = candidates[int(np.flatnonzero(~apart)[0])][0]
    return _Fit(same, poses[best], float(costs[best]), float(costs[apart].min(initial=np.inf)))


def _lead(fits: dict[tuple[int, int], _Fit], costs: Array, columns: tuple[int, ...], row: int) -> float:
    """How much worse it is to turn an object round, or to let it change places with another one."""
    column = columns[row]
    fit = fits[row, column]
    leads = [fit.second - fit.cost]
    for other, place in enumerate(columns):
        if other != row and {(row, place), (other, column)} <= fits.keys():
            leads.append(costs[row, place] + costs[other, column] - costs[row, column] - costs[other, place])
    return max(0.0, min(leads))
