"""What a place is drawn for: a thing, what it refers to, and what is there already."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.placement.contact import Bodies
from tamp.generate.placement.object_model import Thing, yawed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

SKEW = 0.12
"""How far a thing may be turned against its neighbour [rad]."""


@dataclass(frozen=True, eq=False)
class Wish:
    """What a place is drawn for.

    Attributes:
        thing: what is to be placed.
        parent: what it refers to.
        T_parent: where that stands, shape (4, 4).
        others: everything that stands there already, the parent included.
        index, count: which one it is, counted from 0, of how many with this relation to this parent.
        rng: source of what the relation leaves open.
    """

    thing: Thing
    parent: Thing
    T_parent: Matrix
    others: Bodies
    index: int
    count: int
    rng: np.random.Generator

    @property
    def heading(self) -> float:
        """Direction of the parent's x axis seen from above [rad]."""
        return math.atan2(self.T_parent[1, 0], self.T_parent[0, 0])

    def turned(self, turn: float) -> Matrix:
        """The thing upright, turned against the parent's heading by an angle [rad] and a little askew."""
        return yawed(self.thing.resting[0], self.heading + turn + self.rng.uniform(-SKEW, SKEW))

    def quarter(self) -> float:
        """One of four directions [rad]."""
        return float(self.rng.integers(4)) * math.pi / 2

    def over(self, offset: Matrix) -> Matrix:
        """A point over the parent, by its offset from the parent's origin along the parent's heading, shape (2,)."""
        point: Matrix = self.T_parent[:3, 3] + yawed(np.eye(3), self.heading)[:, :2] @ offset
        return point
