"""How far an object slips along the pads when it is lifted.

Pads that press on slopes drive the object out between them, as one shoots a cherry stone, and its weight draws it
down. It slips as long as the work of the closing fingers and its weight gain more than friction takes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.squeezed import Squeezed
from tamp.task import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STEP = 0.001  # between the shifts looked at [m]
GLANCE = 3  # whoever gains nothing by so many steps at once keeps still; a slip that ends sooner does no harm
FARTHEST = 12  # steps
WAYS = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
TRUSTED = 0.8  # share of the friction that is counted on: of 662 grasps it told most of those that were lost


def slipping(squeezed: Squeezed, *poses: Pose) -> float:
    """How far an object slips, held by a grasp and lifted [m]; 0 where it keeps still.

    Args:
        squeezed: the object in the grasp.
        poses: where it is lifted from; the one at which it slips farthest counts.
    """
    upward = squeezed.upward(*poses)
    still = float(squeezed.apart_shifted(np.zeros((1, 3)))[0])

    def gained(ways: Array, steps: Array) -> Array:
        shifts = STEP * ways[:, None] * steps[:, None]
        apart = squeezed.apart_shifted(shifts.reshape(-1, 3)).reshape(len(ways), len(steps))
        drawn = squeezed.weight * (shifts @ -upward.T).max(axis=2)
        energies: Array = squeezed.force * (still - apart) + drawn - 2 * TRUSTED * squeezed.friction * STEP * steps
        return energies

    ways = WAYS[gained(WAYS, np.array([float(GLANCE)]))[:, 0] > 0.0]
    if not len(ways):
        return 0.0
    return STEP * max(map(_reached, gained(ways, np.arange(1.0, FARTHEST + 1))))


def _reached(gained: Array) -> int:
    """How many steps it goes on, each gaining more than all before, alone or with the next two."""
    reached, most = 0, 0.0
    for count, energy in enumerate(gained, 1):
        if energy > most:
            reached, most = count, float(energy)
        elif count > reached + 2:
            break
    return reached
