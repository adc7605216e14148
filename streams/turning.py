"""How far an object turns between the pads when it is lifted.

Pads are flat: what they pinch on slanted faces turns until it lies flat between them, and what hangs beside them sags.
The object turns as long as the work of the closing fingers and its weight gain more than friction takes. It is looked
at turning about the line across the pads and about the approach axis; about the closing axis the whole face of a pad
resists.
"""

from __future__ import annotations

import itertools
import math
from functools import partial
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.squeezed import Squeezed
from tamp.task import Pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP = 0.04  # between the angles looked at [rad]
FARTHEST = 0.7  # it is enough to know that it turns this far [rad]
GLANCES = (1, 3, 7, 19)  # steps are looked at in stretches from one of these to the next; most end in the first
TRUSTED = 0.5  # share of the friction that is counted on: lifting shakes, and pads do not touch everywhere


def turning(squeezed: Squeezed, *poses: Pose) -> float:
    """The angle that an object turns by, held by a grasp and lifted [rad]; 0 where it keeps still.

    Args:
        squeezed: the object in the grasp.
        poses: where it is lifted from; the one at which it turns farthest counts.
    """
    resisted = TRUSTED * squeezed.friction * squeezed.width * STEP

    felt: dict[bytes, Array] = {}  # wherever it is lifted from, the first turns looked at are the same

    def energies(turns: Array, up: Array) -> Array:
        key = turns.tobytes()
        if key not in felt:
            felt[key] = squeezed.force * squeezed.apart_turned(turns)
        return felt[key] + squeezed.weight * (turns @ squeezed.center @ up)

    return max(_turned(partial(energies, up=up), resisted) for up in squeezed.upward(*poses))


def _turned(energies: Callable[[Array], Array], resisted: float) -> float:
    """How far it turns [rad]; where it has turned about one axis, it may go on about the other."""
    ways = [(about, step) for about in (_about_side, _about_approach) for step in (STEP, -STEP)]
    turn, steps = np.eye(3), 1
    while steps and _angle(turn) < FARTHEST:
        still = float(energies(turn[None])[0])
        steps, turn = max((_slide(energies, turn, still, *way, resisted) for way in ways), key=itemgetter(0))
    return _angle(turn)


def _slide(
    energies: Callable[[Array], Array],
    turn: Array,
    still: float,
    about: Callable[[float], Array],
    step: float,
    resisted: float,
) -> tuple[int, Array]:
    """How many steps it goes on from a rotation, each setting free more energy than it takes, alone or with the next.

    Returns:
        The number of steps, and the rotation that they lead to, shape (3, 3).
    """
    reached, least = 0, still
    for first, last in itertools.pairwise(GLANCES):
        taken = energies(np.array([about(count * step) @ turn for count in range(first, last)]))
        for count, spent in enumerate(taken, first):
            if spent + count * resisted < least:
                reached, least = count, spent + count * resisted
            elif count > reached + 1:
                return reached, about(reached * step) @ turn
    return reached, about(reached * step) @ turn


def _angle(turn: Array) -> float:
    """By how much a rotation (3, 3) turns [rad]."""
    return math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))


def _about_side(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_approach(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
