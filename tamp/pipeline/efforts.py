"""How hard goals are tried, one level after the other."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """How hard a goal is tried.

    Attributes:
        iterations: of the stream planner; counts, so that a busy machine finds the same plan.
        others_move: whether other objects may be put aside.
        hopeless_too: whether goals that not even the object alone could reach are tried.
    """

    iterations: int
    others_move: bool
    hopeless_too: bool = False


EFFORTS = (Effort(4, False), Effort(8, True), Effort(12, True))
LAST = (Effort(30, True), Effort(12, True, hopeless_too=True))  # once what they will hardly reach is near its goal
ALONE = 6  # iterations after which an object that cannot reach its goal even alone counts as hopeless
