"""What an object takes along by friction on its way: it rubs on that, is wedged in it, or is dragged over it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.world.collision.checker import Contact
from tamp.world.transforms import moved, rotation, turned_about

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.world import World

    Array = NDArray[np.float64]

PRESSED, RUBBED = 0.00015, 0.004  # what slides so far, and is so deep in others, takes those along [m]
CLOSE = 0.002  # between poses that tell what an object rubs on [m]
OFF = 0.005  # so far from its rest an object has left it [m]
IN = 5e-5  # what is no deeper than this in something slides out of it [m]
STOOD_UPON = 0.002  # what is nearer than this to something at rest touches it there [m]
LEVEL = 0.9  # vertical component of the normals of contacts with what is stood upon
ASIDE = (1.0, 1.5)  # so many times as far as it is in something it is moved aside ...
SIDES = 16  # ... in so many directions across its way ...
TURNS = (0.0, -0.01, 0.01, -0.02, 0.02)  # ... and turned about that [rad]
SHIFTS = tuple(
    (far * np.cos(angle), far * np.sin(angle), turn)
    for far in (0.0, *ASIDE)
    for angle in (np.arange(SIDES if far else 1) * 2 * np.pi / SIDES)
    for turn in TURNS
)  # all of them: how far to both sides, in depths, and the turn


def close_together(passed: Array) -> Array:
    """Poses on a way, shape (n, 4, 4), near to each other: what rubs is seen then. All are turned as the first is."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(passed[:, :3, 3], axis=0), axis=1))])
    found = np.repeat(passed[:1], int(length[-1] / CLOSE) + 2, axis=0)
    for axis in range(3):
        found[:, axis, 3] = np.interp(np.linspace(0.0, length[-1], len(found)), length, passed[:, axis, 3])
    return found


def rubbed(world: World, obj: str, passed: Array, others: Mapping[str, Array]) -> Contact | None:
    """Which of some others an object takes along by friction, as it presses on it on its way.

    `passed` are its poses on the way, shape (n, 4, 4); the others stand at theirs, (4, 4) each.
    """
    ways = np.linalg.norm(np.diff(passed[:, :3, 3], axis=0), axis=1)
    for name in sorted(others):
        presses = np.zeros(len(passed), bool)
        presses[[*world.overlapping(obj, passed, name, others[name], tolerance=PRESSED)]] = True
        if ways[presses[1:] & presses[:-1]].sum() > RUBBED:
            return Contact(obj, name, -PRESSED)
    return None


def dragged_over(world: World, obj: str, passed: Array, others: Mapping[str, Array]) -> Contact | None:
    """What an object stands level on, and still presses on where it has left its place sideways; as in `rubbed`."""
    aside = passed[np.linalg.norm((passed - passed[0])[:, :2, 3], axis=1) > OFF]
    for name in sorted(others) if len(aside) else ():
        _, normals = world.contacts(obj, passed[0], name, others[name], STOOD_UPON)
        level = len(normals) and (normals[:, 2] > LEVEL).all()
        if level and world.overlaps(obj, aside, name, others[name], tolerance=IN):
            return Contact(obj, name, -IN)
    return None


def wedged(world: World, obj: str, passed: Array, others: Mapping[str, Array]) -> Contact | None:
    """What an object is stuck in where it has left its rest: it presses on that wherever it is moved a little aside.

    Friction would take that along. What one wall presses on moves aside and slides on; between two it cannot.
    `passed` and `others` are as in `rubbed`, the rest first.
    """
    order = [*range(len(SHIFTS))]
    ways = passed[:, :3, 3] - passed[0, :3, 3]
    left = np.flatnonzero(np.linalg.norm(ways, axis=1) > OFF)
    pressing = ((k, name) for name in others for k in world.overlapping(obj, passed[left], name, others[name], IN))
    for k, name in sorted(pressing):
        T, way = passed[left[k]], ways[left[k]]
        depth = -world.separation(obj, T, name, others[name])
        ways_out = _aside(T, way / float(np.linalg.norm(way)), depth, order)
        free = (shift for shift, at in ways_out if not world.overlap(obj, at, name, others[name], tolerance=IN))
        if (out := next(free, None)) is None:
            return Contact(obj, name, -IN)
        order.insert(0, order.pop(order.index(out)))  # a little further on, the same leads out again
    return None


def _aside(T: Array, way: Array, depth: float, order: Sequence[int]) -> Iterator[tuple[int, Array]]:
    """A pose, shape (4, 4), moved across a way, a unit vector, by about a depth [m], and turned about it.

    With each the number of its shift among `SHIFTS`; `order` has them in the order in which they are tried.
    """
    across = np.linalg.svd(way[None])[2][1:]
    for k in order:
        right, up, turn = SHIFTS[k]
        yield k, moved(turned_about(T[:3, 3], rotation(way, turn), T), depth * (right * across[0] + up * across[1]))
