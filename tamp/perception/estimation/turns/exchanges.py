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
    given = {i: place for i, place in places.items() if (kinds[i], place) in costs}
    while (swapped := _after_best_swap(kinds, costs, given, poses)) is not None:
        given = swapped
    there = {place: kinds[i] for i, place in given.items()}
    leads = {i: lead for i, place in given.items() if (lead := _lead(costs, there, place)) is not None}
    return Exchange(given, {i: best[kinds[i], place] for i, place in given.items()}, leads)


def _given(
    objects: Sequence[int], kinds: Mapping[int, int], there: Mapping[int, int], poses: Collection[tuple[int, int]]
) -> dict[int, int] | None:
    """A place of its mesh for each object, where it may be; None where one has none left."""
    free = list(there)
    apart = np.array([[float(kinds[i] != there[at] or (i, at) not in poses) for at in free] for i in objects])
    columns = assigned(apart.reshape(len(objects), len(free)))
    fits = not any(apart[row, column] for row, column in enumerate(columns))
    return {i: free[column] for i, column in zip(objects, columns, strict=True)} if fits else None


def _after_best_swap(
    kinds: Mapping[int, int],
    costs: Mapping[tuple[int, int], float],
    given: Mapping[int, int],
    poses: Collection[tuple[int, int]],
) -> dict[int, int] | None:
    """Object -> place after the change of two that makes the pictures likeliest; None where none does clearly.

    What pictures say of one object of a mesh they say of all; but each must have a place left where it may be.
    """
    there = {place: kinds[i] for i, place in given.items()}
    gains = {(place, other): -more for place in there for other, more, _ in _swaps(costs, there, place)}
    for place, other in sorted((pair for pair in gains if gains[pair] > CLEARLY), key=lambda pair: -gains[pair]):
        swapped = {**there, place: there[other], other: there[place]}
        if (after := _given([*given], kinds, swapped, poses)) is not None:
            return after
    return None


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
