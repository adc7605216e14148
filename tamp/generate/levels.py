"""Five levels of difficulty, and what a task must show to be of one."""

from __future__ import annotations

from dataclasses import dataclass

Bounds = tuple[int, int]

MANY = 99


@dataclass(frozen=True)
class Level:
    """What tasks of a level have; every count is least and most.

    Attributes:
        number: 1 to 5.
        objects: objects, all of which must move.
        stacked: goals that rest on or in another object.
        occupied: goals that overlap where another object stands at the start.
        cycles: groups of objects of which each waits for the next to leave its goal.
        reoriented: objects that are turned over by more than 60 degrees.
        untidy: the most objects that stand in a relation to another at the start.
        stacked_start: whether some of them may rest on or in another.
    """

    number: int
    objects: Bounds
    stacked: Bounds = (0, 0)
    occupied: Bounds = (0, 0)
    cycles: Bounds = (0, 0)
    reoriented: Bounds = (0, 0)
    untidy: int = 0
    stacked_start: bool = False


LEVELS = (
    Level(1, (2, 4)),
    Level(2, (3, 5), stacked=(1, MANY), untidy=1),
    Level(3, (4, 6), stacked=(1, MANY), occupied=(1, MANY), untidy=2, stacked_start=True),
    Level(4, (5, 8), stacked=(1, MANY), occupied=(2, MANY), cycles=(1, MANY), untidy=3, stacked_start=True),
    Level(5, (6, 10), (1, MANY), (2, MANY), (0, MANY), reoriented=(1, MANY), untidy=4, stacked_start=True),
)


def level(number: int) -> Level:
    """The level of a number from 1 to 5."""
    return LEVELS[number - 1]
