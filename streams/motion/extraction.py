"""Extraction: how an object gets out from between others, by a search over shifts of the object alone.

Best-first search over a lattice of shifts, upwards and aside (Pearl, Heuristics, 1984): along the world's axes, and
along the object's own, since what lies close to others slides along its faces. The object does not turn on its way, and
no hand is asked about.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Mapping
from itertools import count, pairwise, product
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.collisions import ARM_MARGIN
from tamp.streams.motion.handling_contacts import touched
from tamp.streams.rubbing import PRESSED
from tamp.world.transforms import moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.world import World

    Array = NDArray[np.float64]

UP, ASIDE = 0.005, 0.004  # steps of the lattice [m]
WORLD = np.diag([ASIDE, ASIDE, UP])
RISE, HIGHEST = 24, 72  # steps up after which it is out, and after which it is not looked at whether it is well clear
BEND = 1.0  # what a step costs that goes on in another direction than the one before, in steps up
MOST = 1500  # shifts looked at
STEP = 0.005  # between two poses that are looked at [m]

Node = tuple[int, int, int]
Way = tuple[tuple[float, float, float], ...]
"""Shifts that an object passes, one after the other [m]."""

SIDEWAYS = (0, -1, 1, -3, 3)
STEPS: list[Node] = sorted(
    (step for step in product(SIDEWAYS, SIDEWAYS, (1, 0)) if any(step)),
    key=lambda step: (-step[2], step[0] ** 2 + step[1] ** 2),
)
"""From one node to the next, those that rise first, and the steepest of those."""


def extraction(world: World, obj: str, T: Array, others: Mapping[str, Array]) -> Way | None:
    """Shifts by which an object leaves where it is, past all others; None where none is found.

    What it touches it may touch on, but not press on. Where possible it ends well clear of all.

    Args:
        world: geometry of the objects.
        obj: the object.
        T: T_world_object, shape (4, 4).
        others: T_world_other of each that stands around, shape (4, 4).
    """
    touch = touched(world, obj, T, others, scraped=PRESSED)

    def free(*shifts: Array) -> bool:
        return not meets(world, obj, T, np.array(shifts), others, touch)

    def clear(shift: Array) -> bool:
        return not meets(world, obj, T, shift[None], others, dict.fromkeys(others, ARM_MARGIN))

    lattices = (WORLD, upright(T[:3, :3]) @ WORLD)
    found = ((lattice, _search(lattice, free, clear)) for lattice in lattices)
    ways = [_straightened(lattice, nodes, free) for lattice, nodes in found if nodes is not None]
    return min(ways, key=_length, default=None)


def meets(
    world: World, obj: str, T: Array, shifts: Array, others: Mapping[str, Array], near: Mapping[str, float]
) -> bool:
    """Whether an object meets others on its way from T, straight from each of some shifts to the next, (n, 3) [m].

    To those in `near` it may come as near as that says; negative is how deep it may be in them [m].
    """
    legs = [np.linspace(a, b, math.ceil(float(np.linalg.norm(b - a)) / STEP) + 1) for a, b in pairwise(shifts)]
    along = moved(T, np.concatenate(legs or [shifts]))
    return any(world.overlaps(obj, along, other, at, tolerance=-near.get(other, 0.0)) for other, at in others.items())


def _length(way: Way) -> float:
    """Of a way from no shift [m]."""
    return sum(math.dist(a, b) for a, b in pairwise([(0.0, 0.0, 0.0), *way]))


def upright(R: Array) -> Array:
    """The axes of a rotation, shape (3, 3), in such an order and of such signs that the third points most upwards."""
    third = int(np.abs(R[2]).argmax())
    axes = np.roll(R, 2 - third, axis=1)
    return axes if axes[2, 2] > 0.0 else axes * (1.0, -1.0, -1.0)


def _search(lattice: Array, free: Callable[..., bool], clear: Callable[[Array], bool]) -> list[Node] | None:
    """Nodes from no shift to one that is out; the lattice's steps are the columns of a matrix, (3, 3) [m].

    It is greedy, so that there are few bends but not the fewest. Whether a node is free is asked once, and whether the
    step to it is only when its turn has come (Bohlin and Kavraki, Path planning using lazy PRM, ICRA 2000).
    """
    order = count()
    start: Node = (0, 0, 0)
    waiting: list[tuple[float, int, Node, list[Node]]] = [(float(RISE), next(order), STEPS[0], [start])]
    reached, shut = set[Node](), set[Node]()
    out: list[Node] | None = None
    while waiting and len(reached) + len(shut) < MOST:
        cost, _, last, way = heapq.heappop(waiting)
        node = way[-1]
        if node in reached or node in shut:
            continue
        if not free(lattice @ node):
            shut.add(node)
            continue
        if not free(*(lattice @ passed for passed in way[-2:])):
            continue
        if node[2] >= RISE:
            if clear(lattice @ node):
                return way
            out = out or way
        reached.add(node)
        for step in STEPS:
            after: Node = (node[0] + step[0], node[1] + step[1], node[2] + step[2])
            if after[2] <= HIGHEST and after not in reached and after not in shut:
                bend = BEND if step != last else 0.0
                heapq.heappush(waiting, (cost - step[2] + bend, next(order), step, [*way, after]))
    return out


def _straightened(lattice: Array, nodes: list[Node], free: Callable[..., bool]) -> Way:
    """The shifts after the first that are left when each is followed by the last that it leads straight to."""
    kept, here = list[Node](), 0
    while here < len(nodes) - 1:
        farther = range(len(nodes) - 1, here + 1, -1)
        here = next((last for last in farther if free(lattice @ nodes[here], lattice @ nodes[last])), here + 1)
        kept.append(nodes[here])
    x, y, z = lattice @ np.array(kept).T
    return tuple(zip(x.tolist(), y.tolist(), z.tolist(), strict=True))
