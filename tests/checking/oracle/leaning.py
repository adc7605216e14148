"""Does what is written on its edge, by itself, fall to the side to which it leans?"""

from __future__ import annotations

from itertools import product

import numpy as np

from tamp.task import Box
from tests.checking.oracle.world import World

LOW = 5e-4  # corners so near the table stand on it [m]
BEYOND = 0.008  # so far beyond or within its edge what leans falls, or stands up, for certain [m]
ASIDE = 0.03  # what lies on one side of an edge has its middle so far there [m]
REACH = 0.35  # nothing so near touches it as it falls [m]


def leaning(world: World) -> str | None:
    """A box, far from all others, that is said to lie where it cannot have fallen from its edge."""
    for thing in world.task.objects:
        if not isinstance(thing.shape, Box):
            continue
        written, said = thing.pose.matrix, world.poses[thing.name]
        others = [T[:2, 3] for T in world.others(thing.name, "table").values()]
        if any(np.linalg.norm(at - written[:2, 3]) < REACH for at in others):
            continue
        corners = np.array(list(product((-0.5, 0.5), repeat=3))) * thing.shape.size @ written[:3, :3].T + written[:3, 3]
        edge = corners[np.abs(corners[:, 2]) < LOW]
        if len(edge) != 2:
            continue
        across = np.cross(edge[1] - edge[0], (0.0, 0.0, 1.0))[:2]
        across /= np.linalg.norm(across)
        lean = float((written[:2, 3] - edge[0, :2]) @ across)
        across, lean = np.sign(lean) * across, abs(lean)
        ended = float((said[:2, 3] - edge[0, :2]) @ across)
        upright = np.sort(np.abs(written[2, :3]))[2] > np.cos(0.08)
        lies = abs(said[2, :3] @ written[2, :3]) < 0.3
        # What leans a little stands on an edge that is not ahead of its middle: it would turn back over that.
        if lies and ((upright and lean > BEYOND) or (not upright and lean > BEYOND and ended < -ASIDE)):
            return f"{thing.name} lies where it does not fall"
    return None
