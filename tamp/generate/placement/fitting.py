"""Whether one thing is of a size to stand in a relation to another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.placement.object_model import Thing

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

OVERHANG = 1.05
"""How much wider than a place a thing's foot may be."""


def fits(relation: str, child: Thing, parent: Thing) -> bool:
    """Whether a child can stand in a relation to a parent, by their sizes."""
    R = child.resting[0]
    if relation == "in":
        return _goes_into(child.outline(R)[:2], parent.model.hollow, 1.1)
    if relation == "on":
        return _goes_into(child.foot(R), parent.model.top, OVERHANG)
    if relation == "stacked":
        return child.model == parent.model or _goes_into(child.foot(R), parent.model.top, OVERHANG)
    if relation == "standing":
        length, *across = sorted(child.outline(R), reverse=True)
        return _goes_into(np.array(across), parent.model.hollow, 0.6) and length > 0.09
    if relation == "leaning":
        thin, _, high = child.outline(R)
        return bool(thin < 0.45 * high and parent.outline(parent.resting[0])[2] > 0.6 * high)
    return True


def _goes_into(sides: Matrix, area: tuple[float, float] | None, slack: float) -> bool:
    if area is None:
        return False
    return all(side <= slack * room for side, room in zip(sorted(sides), sorted(area), strict=True))
