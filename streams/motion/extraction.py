"""Extraction: how an object gets out from between others, by a search over shifts of the object alone.

Best-first search over a lattice of shifts, layer by layer upwards (Pearl, Heuristics, 1984). The object does not turn
on its way, and no hand is asked about.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from itertools import count, pairwise, product
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.motion.handling_contacts import touched
from tamp.streams.rubbing import PRESSED
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.world import World

    Array = NDArray[np.float64]

UP, ASIDE = 0.01, 0.004  # steps of the lattice [m]
RISE = 12  # steps up after which it is out
BEND = 0.5  # what a step costs that goes on in another direction than the one before, in steps
MOST = 1500  # shifts looked at
STEP = 0.005  # between two poses that are looked at [m]

Node = tuple[int, int, int]
Way = tuple[tuple[float, float, float], ...]
"""Shifts that an object passes, one after the other [m]."""

SIDEWAYS = (0, -1, 1, -3, 3)
STEPS = sorted(product(SIDEWAYS, SIDEWAYS), key=lambda step: step[0] ** 2 + step[1] ** 2)
"""Sideways steps from one layer to the next, the steepest first."""


def extraction(world: World, obj: str, T: Array, others: Mapping[str, Array]) -> Way | None:
    """Shifts by which an object leaves where it is, past all others; None where none is found.

    What it touches it may touch on, but not press on.

    Args:
        world: geometry of the objects.
        obj: the object.
        T: T_world_object, shape (4, 4).
        others: T_world_other of each that stands around, shape (4, 4).
    """
    touch = touched(world, obj, T, others, scraped=PRESSED)

    def free(*shifts: Array) -> bool:
        return not meets(world, obj, T, np.array(shifts), others, touch)

    nodes = _search(free)
    return None if nodes is None else _straightened(nodes, free)


def meets(
    world: World, obj: str, T: Array, shifts: Array, others: Mapping[str, Array], near: Mapping[str, float]
) -> bool:
    """Whether an object meets others on its way from T, straight from each of some shifts to the next, (n, 3) [m].

    To those in `near` it may come as near as that says; negative is how deep it may be in them [m].
    """
    legs = [np.linspace(a, b, ceil(float(np.linalg.norm(b - a)) / STEP) + 1) for a, b in pairwise(shifts)] or [shifts]
    along = moved(T, np.concatenate(legs))
    return any(world.overlaps(obj, along, other, at, tolerance=-near.get(other, 0.0)) for other, at in others.items())


def _at(node: Node) -> Array:
    return np.array([node[0] * ASIDE, node[1] * ASIDE, node[2] * UP])


def _search(free: Callable[..., bool]) -> list[Node] | None:
    """Nodes from no shift to one that is high enough.

    It is greedy, so that there are few bends but not the fewest. Whether a node is free is asked once, and whether the
    step to it is only when its turn has come (Bohlin and Kavraki, Path planning using lazy PRM, ICRA 2000).
    """
    order = count()
    start: Node = (0, 0, 0)
    waiting: list[tuple[float, int, tuple[int, int], list[Node]]] = [(float(RISE), next(order), (0, 0), [start])]
    reached, shut = set[Node](), set[Node]()
    while waiting and len(reached) + len(shut) < MOST:
        cost, _, last, way = heapq.heappop(waiting)
        node = way[-1]
        if node in reached or node in shut:
            continue
        if not free(_at(node)):
            shut.add(node)
            continue
        if not free(*map(_at, way[-2:])):
            continue
        if node[2] == RISE:
            return way
        reached.add(node)
        for step in STEPS:
            after: Node = (node[0] + step[0], node[1] + step[1], node[2] + 1)
            if after not in reached and after not in shut:
                bend = BEND if step != last else 0.0
                heapq.heappush(waiting, (cost - 1.0 + bend, next(order), step, [*way, after]))
    return None


def _straightened(nodes: list[Node], free: Callable[..., bool]) -> Way:
    """The shifts after the first that are left when each is followed by the last that it leads straight to."""
    kept, here = list[Node](), 0
    while here < len(nodes) - 1:
        farther = range(len(nodes) - 1, here + 1, -1)
        here = next((last for last in farther if free(_at(nodes[here]), _at(nodes[last]))), here + 1)
        kept.append(nodes[here])
    return tuple((x * ASIDE, y * ASIDE, up * UP) for x, y, up in kept)
