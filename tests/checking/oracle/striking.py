"""Is a thin box dragged over by what moves and is hardly in it? Which boxes stay that are said to start elsewhere?"""

from __future__ import annotations

import numpy as np

from tamp.task import Box, Shape, Task
from tests.checking.oracle.bodies import Body, depth, near

PRESSED = 0.0004  # deeper than that it presses [m]
FLAT = 0.9999  # cosine between up and an axis of what stands upright
STAYS = (0.002, 0.0058)  # so far aside of where it stands flat it may be said to start [m]
MET = 0.002  # so deep what stays is met [m]


def dragged_over(shape: Shape, still: Body, at: np.ndarray, moving: Body, T: np.ndarray) -> bool:
    """Whether a body at poses T, shape (n, 4, 4), takes the top of a thin box along so far that it tips over."""
    if not isinstance(shape, Box) or abs(at[2, 2]) < FLAT or shape.size[2] < 10 * min(shape.size[:2]):
        return False
    across = int(np.argmin(shape.size[:2]))
    pressed = [k for k in near(moving, T, still, at) if depth(moving, T[k], still, at) > PRESSED]
    ahead = at[:3, across]
    ways = [float((T[k, :3, 3] - T[k - 1, :3, 3]) @ ahead) for k in pressed if k - 1 in pressed]
    return abs(sum(ways)) > 0.8 * shape.size[across]


def staying(task: Task, poses: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Boxes that stand upright on the table where the task has them, and are said to start a little aside of that."""
    found = {}
    for thing in task.objects:
        T, said = thing.pose.matrix, poses[thing.name]
        if not isinstance(thing.shape, Box) or T[2, 2] < FLAT or abs(T[2, 3] - thing.shape.size[2] / 2) > 2e-4:
            continue
        if STAYS[0] < np.linalg.norm((said - T)[:2, 3]) < STAYS[1] and min(thing.shape.size[:2]) > 0.04:
            found[thing.name] = T
    return found
