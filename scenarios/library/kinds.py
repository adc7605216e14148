"""What a kind of object is: a function of a few sizes that returns a body, and the range of each size."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tamp.scenarios.parts import Part, Range

CATEGORIES = (
    "toy", "plate", "cup", "cutlery", "box", "scissor", "bowl", "kettle", "can", "pen", "bottle", "tool",
)  # fmt: skip
"""The twelve of the OCRTOC paper's list of objects."""

Area = tuple[float, float]
Folds = tuple[int, int, int]

PLAIN: Folds = (1, 1, 1)
ROUND: Folds = (1, 1, 0)
"""Looks the same however it is turned about its z axis."""
BARREL: Folds = (2, 2, 0)
BRICK: Folds = (2, 2, 2)
CROSS: Folds = (1, 1, 4)
HALF: Folds = (1, 1, 2)
FLIP: Folds = (2, 1, 1)


@dataclass(frozen=True, eq=False)
class Body:
    """One object of a kind, z up as it is used, long and flat ones along x.

    Attributes:
        parts: closed convex parts in any position.
        top: sides of the flat area in its middle on which others can stand [m]; None where there is none.
        hollow: sides of the opening in its middle into which others can be put [m]; None where there is none.
    """

    parts: Sequence[Part]
    top: Area | None = None
    hollow: Area | None = None


@dataclass(frozen=True)
class Kind:
    """A family of objects that differ in size.

    Attributes:
        name: such as "mug".
        category: one of CATEGORIES.
        build: takes the sizes by name [m] and returns the body.
        sizes: size -> least and most [m].
        density: mean density of its parts [kg/m^3].
        symmetry: in how many turns about x, y, z it looks the same; 1 none, 2 half turns, 0 any turn.
        friction: coefficient of lateral friction.
    """

    name: str
    category: str
    build: Callable[..., Body]
    sizes: Mapping[str, Range]
    density: float
    symmetry: Folds = PLAIN
    friction: float = 0.5

    def draw(self, rng: np.random.Generator) -> dict[str, float]:
        """Sizes drawn evenly from their ranges, whole tenths of a millimetre [m]."""
        return {name: round(float(rng.uniform(*ends)), 4) for name, ends in self.sizes.items()}
