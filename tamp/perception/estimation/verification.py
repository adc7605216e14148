"""The last word on who is where, and which way round: residuals tell shapes apart that differ by millimetres.

The joint choice forgives a few millimetres, since guesses err by that much. Here every candidate in a chosen place, of
the object that was chosen for it and of any other, is fitted to the place's own points; what fits best with everything
else is an assignment of objects to places (Kuhn, 1955). Where points hardly tell who has changed places with whom,
whole pictures do.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.assignment import assigned
from tamp.perception.estimation.candidates import Candidate, different
from tamp.perception.estimation.fit import agreement, gaps, polished
from tamp.perception.estimation.fusion import VOXEL, Cloud
from tamp.perception.estimation.models.object_model import ObjectModel
from tamp.perception.estimation.selection import Selection
from tamp.perception.estimation.turns.exchanges import Exchange, told_apart
from tamp.perception.estimation.turns.likeness import FIRST, fitted_turns, likeliest_near, misfits
from tamp.perception.estimation.volume import Volume
from tamp.perception.rendering.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

VARIANTS = 8
"""Candidates of one object, each clearly another pose, that are fitted in one place."""

POINTS = 2500
"""Points of a place, about, that candidates are fitted to; the one that is kept is fitted to all."""

APART = 0.02
"""Poses of an object that differ by less than this, over its symmetries, are the same [m]."""

ALIKE = (0.01, 0.2)
"""Candidates in one place that differ by less than this are fitted once [m, rad]."""

CLAIMED = 0.5
"""A point that is explained better than this elsewhere may be another object's."""

CLOSER = 0.08
"""What fits better by so much of the likelihood's logarithm a point is trusted by two thirds: errors of neighbours go
together."""

SURELY = 3.0
"""What fits better by so many times that is not asked of pictures again."""

SHOWN = 0.03
"""What pictures show better by such a share of their likelihood's logarithm is trusted by two thirds."""

TURNS = 80
"""More turns than this are not rendered: they are a ball's."""

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
        shown: whether whole pictures have told its turn.
        rival: the best of its other poses in its place, clearly turned, shape (4, 4); None where there is none.
        exchanged: `lead`, of other objects in exchange alone.
    """

    candidate: int
    pose: Array
    own: NDArray[np.int64]
    lead: float
    shown: bool = False
    rival: Array | None = None
    exchanged: float = np.inf


@dataclass(frozen=True, eq=False)
class _Fit:
    """An object fitted in a place: the best candidate's pose and cost, and those of the best clearly different one."""

    candidate: int
    pose: Array
    cost: float
    rival: Array | None
    second: float


def verify(
    scene: Volume,
    surfaces: Sequence[Surface],
    models: Sequence[ObjectModel],
    found: Sequence[Sequence[Candidate]],
    selection: Selection,
) -> dict[int, Verified]:
    """Object -> what is made of it, for all that the selection has chosen a candidate for."""
    seen = [i for i, k in enumerate(selection.chosen) if k >= 0]
    rivals = [_rivals(models, found, selection, seen, place) for place in seen]
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
    exchange = _exchanged(scene, [(surfaces[i], models[i]) for i in seen], fits, costs, columns, owns)
    columns = tuple(exchange.places.get(row, column) for row, column in enumerate(columns))
    verified = {}
    for row, (i, column) in enumerate(zip(seen, columns, strict=True)):
        fit, own = fits[row, column], owns[column]
        margin = max(0.0, min(_margins(costs, columns, row, exchange.leads)))
        exchanged = min(margin / max(1, len(own)), exchange.leads.get(row, np.inf) / SHOWN * CLOSER)
        lead = min((fit.second - fit.cost) / max(1, len(own)), exchanged)
        pose = exchange.poses.get(row, fit.pose)
        if len(own) >= 2 * POINTS:  # a pose that was fitted to all points would only drift where they leave it free
            pose = polished(scene.cloud, models[i], pose, own)
        verified[i] = Verified(fit.candidate, pose, own, lead, row in exchange.poses, fit.rival, exchanged)
    return verified


def _exchanged(
    scene: Volume,
    objects: Sequence[tuple[Surface, ObjectModel]],
    fits: Mapping[tuple[int, int], _Fit],
    costs: Array,
    columns: Sequence[int],
    owns: Sequence[NDArray[np.int64]],
) -> Exchange:
    """What pictures say of all objects that hardly fit better where they are than exchanged."""
    doubted = {row: column for row, column in enumerate(columns) if _doubted(costs, columns, row, owns)}
    poses = {}
    for (row, column), fit in fits.items():
        if row in doubted and column in doubted.values():
            _, model = objects[row]
            best = min(costs[other, column] for other in doubted)
            if column == doubted[row] or fit.cost - best < SURELY * CLOSER * len(owns[column]):
                turned = not model.colored and 1 < len(model.symmetries) <= TURNS
                poses[row, column] = (
                    fitted_turns(scene.cloud, model, fit.pose, owns[column]) if turned else fit.pose[None]
                )
    return told_apart(scene.frames, {row: objects[row][0] for row in doubted}, doubted, poses)


def _doubted(costs: Array, columns: Sequence[int], row: int, owns: Sequence[NDArray[np.int64]]) -> bool:
    """Whether an object would fit hardly worse if it changed places with another one."""
    limits = [SURELY * CLOSER * max(len(owns[columns[row]]), len(owns[place])) for place in columns]
    return any(lead < limit for lead, limit in zip(_margins(costs, columns, row), limits, strict=True))


def _rivals(
    models: Sequence[ObjectModel],
    found: Sequence[Sequence[Candidate]],
    selection: Selection,
    seen: Sequence[int],
    place: int,
) -> dict[int, list[int]]:
    """Object -> its candidates in the place that was chosen for an object; others of the same mesh have none."""
    chosen = selection.chosen[place]
    center = selection.center(place, chosen)
    some = {i: selection.at(i, center) for i in seen if models[i] is not models[place]}
    some[place] = [chosen, *(k for k in selection.at(place, center) if k != chosen)]
    return {i: _unlike(models[i], found[i], candidates) for i, candidates in some.items() if candidates}


def _unlike(model: ObjectModel, found: Sequence[Candidate], order: Sequence[int]) -> list[int]:
    """The first of an object's candidates, in order, that are clearly other poses than the earlier ones.

    What is nearly the same comes to the same once it is fitted; a dozen such would leave no room for another turn.
    """
    kept = different(np.array([found[k].pose for k in order]), model, *ALIKE, VARIANTS)
    return [order[k] for k in kept]


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
    few = own[:: max(1, len(own) // FIRST)]
    starts = [(k, start) for k, pose in candidates for start in _starts(scene.cloud, model, pose, some, few)]
    poses = np.stack([likeliest_near(scene.cloud, model, start, few)[0] for _, start in starts])
    seen_through = agreement(scene, model, poses, len(model.points)).violations * model.area / VOXEL**2
    costs = seen_through + misfits(scene.cloud, model, poses, some) * len(own) / max(1, len(some))
    best = int(costs.argmin())
    apart = np.array([model.error(poses[best], pose) for pose in poses]) > APART
    second = int(np.where(apart, costs, np.inf).argmin())
    # Candidates that come to the same pose are one: the first, which explained most before it was fitted.
    same = starts[int(np.flatnonzero(~apart)[0])][0]
    if not apart.any():
        return _Fit(same, poses[best], float(costs[best]), None, np.inf)
    return _Fit(same, poses[best], float(costs[best]), poses[second], float(costs[second]))


def _starts(
    cloud: Cloud, model: ObjectModel, pose: Array, some: NDArray[np.int64], few: NDArray[np.int64]
) -> Iterator[Array]:
    """Where turning a pose on by colours begins: fitted to some points by shape, and as it is if that was likelier.

    What is round may be turned by a fit by shape until its colours are elsewhere.
    """
    fitted = polished(cloud, model, pose, some)
    yield fitted
    if model.colored:
        before, after = misfits(cloud, model, np.stack([pose, fitted]), few)
        if before < after:
            yield pose


def _margins(costs: Array, columns: Sequence[int], row: int, but: Collection[int] = ()) -> list[float]:
    """How much worse it is that an object changes places with each one; infinite if it cannot, or either is `but`."""
    column = columns[row]
    margins = []
    for other, place in enumerate(columns):
        swapped = costs[row, place] + costs[other, column]
        told = other == row or swapped >= NEVER or row in but or other in but
        margins.append(np.inf if told else float(swapped - costs[row, column] - costs[other, place]))
    return margins
