"""Which of several objects that points hardly tell apart stands where: whole pictures tell them as they tell turns.

Plates that differ by half a millimetre fit each other's points within what cameras and calibration err. Each that may
be in a place is rendered there, at its best turn, and what each view errs by as a whole is taken out; two change places
where that makes the pictures clearly likelier.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.assignment import assigned
from tamp.perception.estimation.fusion import LevelFrame
from tamp.perception.estimation.turns.rendered import CLEARLY, all_shown
from tamp.perception.rendering.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Exchange:
    """What pictures say of objects that may have changed places.

    Attributes:
        places: object -> place, of all that pictures show enough of.
        poses: object -> its pose there, turned as pictures show it best, shape (4, 4).
        leads: object -> how much less likely the pictures are if it changes places with another one, as a share of
            their negative logarithm; of those alone of which they tell it clearly.
    """

    places: Mapping[int, int]
    poses: Mapping[int, Array]
    leads: Mapping[int, float]


def told_apart(
    frames: Sequence[LevelFrame],
    meshes: Mapping[int, Surface],
    places: Mapping[int, int],
    poses: Mapping[tuple[int, int], Array],
) -> Exchange:
    """Give objects the places where pictures show them.

    Args:
        frames: pictures of a scene that stood still.
        meshes: object -> mesh; of one mesh any may be anywhere.
        places: object -> the place that it has so far.
        poses: object and place -> poses there, shape (n, 4, 4), that differ by turns; missing where it cannot be.
    """
    kinds = {i: id(mesh) for i, mesh in meshes.items()}
    costs: dict[tuple[int, int], float] = {}
    best: dict[tuple[int, int], Array] = {}
    for place in places.values():
        rivals = {kinds[i]: i for i, at in poses if at == place}
        shown = all_shown(frames, [(meshes[i], poses[i, place]) for i in rivals.values()])
        for (kind, i), one in zip(rivals.items(), shown, strict=True) if shown is not None else ():
            costs[kind, place], best[kind, place] = one.cost, poses[i, place][one.pose]
    there = {place: kinds[i] for i, place in places.items() if (kinds[i], place) in costs}
    while (swap := _best_swap(costs, there)) is not None:
        here, other = swap
        there[here], there[other] = there[other], there[here]
    given = _given([i for i, place in places.items() if place in there], kinds, there, poses)
    leads = {i: lead for i, place in given.items() if (lead := _lead(costs, there, place)) is not None}
    return Exchange(given, {i: best[kinds[i], place] for i, place in given.items()}, leads)


def _given(
    objects: Sequence[int], kinds: Mapping[int, int], there: Mapping[int, int], poses: Collection[tuple[int, int]]
) -> dict[int, int]:
    """A place of its mesh for each object, one where it may be."""
    free = list(there)
    apart = [[float(kinds[i] != there[place] or (i, place) not in poses) for place in free] for i in objects]
    return {i: free[column] for i, column in zip(objects, assigned(np.array(apart)), strict=True)} if objects else {}


def _best_swap(costs: Mapping[tuple[int, int], float], there: Mapping[int, int]) -> tuple[int, int] | None:
    """The two places whose objects' change makes the pictures likeliest; None where it does not clearly."""
    gains = {(place, other): -more for place in there for other, more, _ in _swaps(costs, there, place)}
    best = max(gains, key=lambda pair: gains[pair], default=None)
    return best if best is not None and gains[best] > CLEARLY else None


def _lead(costs: Mapping[tuple[int, int], float], there: Mapping[int, int], place: int) -> float | None:
    """How much changing an object for one of another mesh costs at least, as a share; None: not clear."""
    swaps = list(_swaps(costs, there, place))
    if not swaps or min(more for _, more, _ in swaps) < CLEARLY:
        return None
    return min(more / now for _, more, now in swaps)


def _swaps(
    costs: Mapping[tuple[int, int], float], there: Mapping[int, int], place: int
) -> Iterator[tuple[int, float, float]]:
    """The places with objects of other meshes that a place's could be changed with, what that costs, and both now."""
    for other in there:
        swapped = (there[other], place), (there[place], other)
        if there[other] != there[place] and all(at in costs for at in swapped):
            now = costs[there[place], place] + costs[there[other], other]
            yield other, sum(costs[at] for at in swapped) - now, now
