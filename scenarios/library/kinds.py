"""What a kind of object is: a function of a few sizes that returns a body, and the range of each size."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tamp.scenarios.parts import Part, Range
from tamp.task.model import ANY_TURN, Symmetry

CATEGORIES = (
    "toy", "plate", "cup", "cutlery", "box", "scissor", "bowl", "kettle", "can", "pen", "bottle", "tool",
)  # fmt: skip
"""The twelve of the OCRTOC paper's list of objects."""

Area = tuple[float, float]

PLAIN = Symmetry()
ROUND = Symmetry(z=ANY_TURN)
BARREL = Symmetry(2, 2, ANY_TURN)
BRICK = Symmetry(2, 2, 2)
CROSS = Symmetry(z=4)
HALF = Symmetry(z=2)
FLIP = Symmetry(x=2)


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
        symmetry: how it may turn and look the same.
        friction: coefficient of lateral friction.
    """

    name: str
    category: str
    build: Callable[..., Body]
    sizes: Mapping[str, Range]
    density: float
    symmetry: Symmetry = PLAIN
    friction: float = 0.5

    def draw(self, rng: np.random.Generator) -> dict[str, float]:
        """Sizes drawn evenly from their ranges, whole tenths of a millimetre [m]."""
        return {name: round(float(rng.uniform(*ends)), 4) for name, ends in self.sizes.items()}
