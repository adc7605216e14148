"""What comes to touch what: things let down onto others, and how near they may be."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.placement.object_model import Thing, transform
from tamp.world.geometry.convex_union import overlap, relative

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

Bodies = Sequence[tuple[Thing, "Matrix"]]

LIFT = 0.0005
"""Things are drawn this far above what they rest on [m]."""


def on_table(thing: Thing, R: Matrix, xy: tuple[float, float] = (0.0, 0.0)) -> Matrix:
    """The pose, shape (4, 4), of a thing turned by `R` that stands on the table at a point."""
    return transform(R, (*xy, LIFT - thing.bottom(R)))


def hits(thing: Thing, T: Matrix, others: Bodies, gap: float = 0.0) -> bool:
    """Whether a thing at a pose comes nearer than `gap` [m] to any of the others."""
    return any(overlap(thing.solid, other.solid, relative(T, T_other), gap) for other, T_other in others)


def lowered(thing: Thing, R: Matrix, over: Matrix, others: Bodies) -> Matrix:
    """The thing turned by `R`, over a point, let down until just above what it touches first."""
    top = max(float((other.points @ T[2, :3]).max() + T[2, 3]) for other, T in others)
    T = transform(R, (float(over[0]), float(over[1]), top - thing.bottom(R) + 0.01))
    floor = -thing.bottom(R)
    step = 0.008
    while step > LIFT:
        lower = T.copy()
        lower[2, 3] -= step
        if lower[2, 3] < floor or hits(thing, lower, others):
            step /= 2
        else:
            T = lower
    return T
