"""What a task asks of a planner, measured on its settled scenes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tamp.generate.graph import TABLE
from tamp.generate.levels import Level
from tamp.generate.placement.contact import hits
from tamp.generate.placement.object_model import Thing
from tamp.generate.scene import Scene
from tamp.scoring.ede import ede, mean_edge, upper_error_bound
from tamp.task import Pose

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

TURNED_OVER = math.radians(60)
"""An object that is tilted further than this on its way counts as reoriented [rad]."""
TOUCH = 0.001
"""Poses that overlap by less than this do not exclude each other [m]."""
WAY = 0.03
"""An object moves where its goal is farther than this from its start (EDE) [m]."""


@dataclass(frozen=True)
class Features:
    """Counts and errors of one task.

    Attributes:
        objects: how many there are.
        moving: how many must move more than 3 cm.
        stacked: goals that rest on or in another object.
        stacked_start: the same at the start.
        occupied: goals that overlap where another object stands at the start.
        cycles: groups of objects of which each waits for the next to leave its goal.
        reoriented: objects turned over by more than 60 degrees, turns in which they look the same left out.
        do_nothing_ede_m: the paper's error of leaving everything where it is [m].
        mean_ueb_m: the mean of its bounds [m].
        floor_ede_m: the error of a perfect robot, whose objects drift as they settle at their goals [m].
    """

    objects: int
    moving: int
    stacked: int
    stacked_start: int
    occupied: int
    cycles: int
    reoriented: int
    do_nothing_ede_m: float
    mean_ueb_m: float
    floor_ede_m: float

    def fit(self, level: Level) -> bool:
        """Whether a task with these is of a level: all objects move, each count within its bounds."""
        counts = ("objects", "stacked", "occupied", "cycles", "reoriented")
        within = (low <= getattr(self, name) <= high for name in counts for low, high in (getattr(level, name),))
        return self.moving == self.objects and all(within)


def measure(things: Mapping[str, Thing], start: Scene, goal: Scene) -> Features:
    """The features of a task.

    Args:
        things: object -> its geometry.
        start: where the objects stand.
        goal: where they shall stand.
    """
    edges = {name: mean_edge(item.model.shape) for name, item in things.items()}
    bounds = [upper_error_bound(item.model.shape) for item in things.values()]
    ways = [ede(edges[name], start.poses[name], goal.poses[name]) for name in things]
    waits = waiting(things, matrices(start.poses), matrices(goal.poses))
    return Features(
        objects=len(things),
        moving=sum(way > WAY for way in ways),
        stacked=_carried(goal),
        stacked_start=_carried(start),
        occupied=sum(map(bool, waits.values())),
        cycles=_cycles(waits),
        reoriented=sum(_turned_over(item, name, start, goal) for name, item in things.items()),
        do_nothing_ede_m=sum(map(min, ways, bounds)) / len(ways),
        mean_ueb_m=sum(bounds) / len(bounds),
        floor_ede_m=sum(goal.drift.values()) / len(goal.drift),
    )


def in_each_others_way(things: Mapping[str, Thing], start: Scene, layout: Mapping[str, Matrix], level: Level) -> bool:
    """Whether a goal layout, not yet settled, has as many occupied goals and cycles as a level wants."""
    waits = waiting(things, matrices(start.poses), layout)
    counts = ((level.occupied, sum(map(bool, waits.values()))), (level.cycles, _cycles(waits)))
    return all(low <= count <= high for (low, high), count in counts)


def waiting(
    things: Mapping[str, Thing], start: Mapping[str, Matrix], goal: Mapping[str, Matrix]
) -> dict[str, set[str]]:
    """Object -> those whose start poses overlap its goal pose; poses of shape (4, 4)."""
    now = {name: (item, start[name]) for name, item in things.items()}
    return {
        name: {other for other in things if other != name and hits(item, goal[name], [now[other]], -TOUCH)}
        for name, item in things.items()
    }


def matrices(poses: Mapping[str, Pose]) -> dict[str, Matrix]:
    """Poses as transforms, shape (4, 4)."""
    return {name: pose.matrix for name, pose in poses.items()}


def _carried(scene: Scene) -> int:
    return len({above for above, below in scene.supports if below != TABLE and above != TABLE})


def _turned_over(item: Thing, name: str, start: Scene, goal: Scene) -> bool:
    up, other = (scene.poses[name].matrix[2, :3] for scene in (start, goal))
    return item.tilt(up, other) > TURNED_OVER


def _cycles(waits: Mapping[str, set[str]]) -> int:
    """The number of strongly connected components of more than one object."""
    reach = {name: _reachable(name, waits) for name in waits}
    components = {frozenset(other for other in reach[name] if name in reach[other]) for name in waits}
    return sum(len(component) > 1 for component in components)


def _reachable(name: str, waits: Mapping[str, set[str]]) -> set[str]:
    found: set[str] = set()
    stack = [name]
    while stack:
        for other in waits[stack.pop()]:
            if other not in found:
                found.add(other)
                stack.append(other)
    return found
