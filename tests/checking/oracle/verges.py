"""Does a box stand on another one alone, its middle, with what it carries, beyond that one's rim as seen from above?"""

from __future__ import annotations

import numpy as np

from tamp.task import Box
from tests.checking.oracle.bodies import depth
from tests.checking.oracle.world import World

BEYOND = 1e-4  # so far beyond the rim is clearly beyond it [m]
UPRIGHT = 0.99999  # cosine of what counts as level
NEAR = 0.004  # what is no farther from it might hold it [m]


def beyond_rim(world: World) -> str | None:
    """Which box falls over the rim of the box that it stands on; None where nothing else near it might hold it."""
    boxes = {o.name: np.array(o.shape.size) for o in world.task.objects if isinstance(o.shape, Box)}
    level = {name: size for name, size in boxes.items() if abs(world.poses[name][2, 2]) > UPRIGHT}
    for name, size in level.items():
        near = [other for other in world.others(name) if _near(world, name, other)]
        high = world.poses[name][2, 3]
        riders = [o for o in near if o in level and world.poses[o][2, 3] > high and _alone_on(world, o, name)]
        near = [other for other in near if other not in riders]
        borne = [world.task.object(other) for other in (name, *riders)]
        if len(near) != 1 or near[0] not in level or any(thing.inertia is not None for thing in borne):
            continue
        under, T = level[near[0]], world.poses[near[0]]
        masses, places = [o.mass for o in borne], [world.poses[o.name][:3, 3] for o in borne]
        middle = T[:3, :3].T @ (np.average(places, axis=0, weights=masses) - T[:3, 3])
        middle[2] = T[:3, 2] @ (world.poses[name][:3, 3] - T[:3, 3])
        stands = abs(abs(middle[2]) - (size[2] + under[2]) / 2) < NEAR
        if stands and world.poses[name][2, 3] > T[2, 3] and (np.abs(middle[:2]) - under[:2] / 2).max() > BEYOND:
            return f"{name} falls over the rim of {near[0]}"
    return None


def _alone_on(world: World, name: str, other: str) -> bool:
    return [o for o in world.others(name) if _near(world, name, o)] == [other]


def _near(world: World, name: str, other: str) -> bool:
    for axis in range(3):
        for shift in (-NEAR, 0.0, NEAR):
            T = world.poses[name].copy()
            T[axis, 3] += shift
            if depth(world.bodies[name], T, world.bodies[other], world.poses[other]) > 0.0:
                return True
    return False
