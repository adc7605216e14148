"""Benchmark families: tasks of boxes that grow with n. The same family, n and seed give the same task everywhere.

Boxes are 5 x 5 x 8 cm up to ten of them and shrink in proportion where more must share the table. What must move
starts on the left half (y > 0); the region to fill lies on the right half and is free at the start.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from random import Random
from types import MappingProxyType

from tamp.task import At, Box, Goal, Object, On, Pose, Region, Task

Point = tuple[float, float]

RIGHT = Region("right", center=(0.0, -0.31), size=(0.3, 0.5))
BASE: Point = (-0.42, 0.0)
"""Where the Panda stands."""
NEAR, FAR = 0.33, 0.70
"""Distances from the base between which the Panda grasps from above with ease [m]."""
JITTER = 0.006
"""How far a box may stand from the middle of its cell, along x and y [m]."""
FINGER = 0.022
"""A finger's thickness: the least room between two boxes of `sort`, `stack` and `permutation` [m]."""
CLUTTER_PITCH = 0.08
TALL = 0.14
DENSE_BOX = (0.04, 0.04, 0.08)
DENSE_CELLS = tuple((-0.2 + 0.08 * i, 0.08 + 0.08 * j) for i in range(6) for j in range(7))
"""A grid of 7 x 6 cells at 8 cm pitch on the left half."""


def sort(n: int, seed: int) -> Task:
    """`n` boxes apart on the left half; each goes anywhere on the region.

    Raises:
        ValueError: unless 1 <= n <= 40.
    """
    random = _start("sort", n, seed, most=40)
    size = _box(n)
    poses = _spread(random, n, size, left=True)
    boxes = [_standing(f"box_{i}", size, pose, On(RIGHT.name)) for i, pose in enumerate(poses)]
    return Task(f"sort_{n}_{seed}", tuple(boxes), regions=(RIGHT,))


def stack(n: int, seed: int) -> Task:
    """`n` boxes in towers of two on the left half, the last one alone where n is odd; each goes onto the region.

    Raises:
        ValueError: unless 1 <= n <= 40.
    """
    random = _start("stack", n, seed, most=40)
    size = _box(n)
    boxes = []
    for tower, pose in enumerate(_spread(random, (n + 1) // 2, size, left=True)):
        for storey in range(min(2, n - 2 * tower)):
            name = f"box_{2 * tower + storey}"
            boxes.append(_standing(name, size, pose, On(RIGHT.name), bottom=storey * size[2]))
    return Task(f"stack_{n}_{seed}", tuple(boxes), regions=(RIGHT,))


def clutter(n: int, seed: int) -> Task:
    """A box of 8 cm ringed by n - 1 boxes of 14 cm on a 3 x 3 grid at 8 cm pitch; only the short one has a goal.

    Raises:
        ValueError: unless 1 <= n <= 9.
    """
    random = _start("clutter", n, seed, most=9)
    middle, yaw = (random.uniform(0.03, 0.09), random.uniform(0.24, 0.30)), random.uniform(-0.3, 0.3)
    places = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
    random.shuffle(places)
    edge, _, height = _box(n)
    boxes = [_standing("short", (edge, edge, height), (*middle, yaw), On(RIGHT.name))]
    for k, (i, j) in enumerate(places[: n - 1]):
        x = middle[0] + CLUTTER_PITCH * (i * math.cos(yaw) - j * math.sin(yaw))
        y = middle[1] + CLUTTER_PITCH * (i * math.sin(yaw) + j * math.cos(yaw))
        boxes.append(_standing(f"tall_{k}", (edge, edge, TALL), (x, y, yaw), None))
    return Task(f"clutter_{n}_{seed}", tuple(boxes), regions=(RIGHT,))


def permutation(n: int, seed: int) -> Task:
    """`n` boxes on both halves whose goals are a random permutation of their start poses.

    Raises:
        ValueError: unless 1 <= n <= 20.
    """
    random = _start("permutation", n, seed, most=20)
    size = _box(n)
    poses = _spread(random, n, size, left=False)
    ends = random.sample(poses, n)
    boxes = [
        _standing(f"box_{i}", size, start, At(_upright(end, size[2] / 2)))
        for i, (start, end) in enumerate(zip(poses, ends, strict=True))
    ]
    return Task(f"permutation_{n}_{seed}", tuple(boxes))


def dense(n: int, seed: int) -> Task:
    """`n` boxes of 4 x 4 x 8 cm on a grid of 8 cm pitch; each goes onto the region, which 40 of them nearly fill.

    Raises:
        ValueError: unless 1 <= n <= 40.
    """
    return _on_grid("dense", n, seed, storeys=1)


def towers(n: int, seed: int) -> Task:
    """The same in towers of two, the last box alone where n is odd.

    Raises:
        ValueError: unless 1 <= n <= 40.
    """
    return _on_grid("towers", n, seed, storeys=2)


FAMILIES: Mapping[str, Callable[[int, int], Task]] = MappingProxyType(
    {
        "sort": sort,
        "stack": stack,
        "clutter": clutter,
        "permutation": permutation,
        "dense": dense,
        "towers": towers,
    }
)


def _start(family: str, n: int, seed: int, most: int) -> Random:
    """The family's generator for this n and seed, once n is found sensible."""
    if not 1 <= n <= most:
        raise ValueError(f"{family} has tasks for n = 1 to {most}, not {n}")
    return Random(f"{family} {n} {seed}")


def _on_grid(family: str, n: int, seed: int, storeys: int) -> Task:
    """Boxes in cells of the dense grid, so many on top of each other, nearly parallel to it; all go to the region."""
    random = _start(family, n, seed, most=40)
    cells = random.sample(DENSE_CELLS, -(-n // storeys))
    places = [(x, y, random.uniform(-0.1, 0.1)) for x, y in cells]
    boxes = [
        _standing(f"box_{k}", DENSE_BOX, places[k // storeys], On(RIGHT.name), k % storeys * DENSE_BOX[2])
        for k in range(n)
    ]
    return Task(f"{family}_{n}_{seed}", tuple(boxes), regions=(RIGHT,))


def _box(n: int) -> tuple[float, float, float]:
    """The size of a box where n of them share the table [m]."""
    edge = 0.05 if n <= 10 else 0.04 if n <= 20 else 0.025
    return edge, edge, round(1.6 * edge, 3)


def _spread(random: Random, n: int, size: tuple[float, float, float], left: bool) -> list[tuple[float, float, float]]:
    """`n` places (x, y, yaw) far enough apart for a finger between any two boxes: cells of a grid, drawn, jittered."""
    pitch = math.sqrt(2) * size[0] + 2 * JITTER + FINGER
    cells = _cells(pitch, left)
    if n > len(cells):
        raise ValueError(f"only {len(cells)} boxes of {size[0]} m fit on the table, not {n}")
    return [
        (
            x + random.uniform(-JITTER, JITTER),
            y + random.uniform(-JITTER, JITTER),
            random.uniform(-math.pi / 4, math.pi / 4),
        )
        for x, y in random.sample(cells, n)
    ]


def _cells(pitch: float, left: bool) -> list[Point]:
    """The points of a grid that the robot reaches with ease; the left half alone, or both."""
    lowest = 0.06 if left else -0.5
    points = [(-0.22 + i * pitch, lowest + j * pitch) for i in range(20) for j in range(40)]
    return [p for p in points if p[0] <= 0.25 and p[1] <= 0.55 and NEAR <= math.dist(p, BASE) <= FAR]


def _standing(
    name: str,
    size: tuple[float, float, float],
    place: tuple[float, float, float],
    goal: Goal | None,
    bottom: float = 0.0,
) -> Object:
    """A box that stands at (x, y, yaw) with its lower face at height `bottom` [m]."""
    return Object(name, Box(size), _upright(place, bottom + size[2] / 2), goal)


def _upright(place: tuple[float, float, float], z: float) -> Pose:
    x, y, yaw = place
    return Pose.from_rpy((x, y, z), (0.0, 0.0, yaw))
