"""Does a pile topple? The centre of all that a body carries, and of itself, beside what carries them."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tests.checking.oracle.bodies import depth, within
from tests.checking.oracle.world import World

LOWERED = 0.006  # what meets another body when it is lowered so far stands on it [m]
BESIDE = 0.01  # a centre so far beside what carries it is clearly not over it [m]
DRAWN = 4000  # points of the box round a body, of which those inside it say where its centre is


def toppling(world: World) -> str | None:
    """Which body tips with all that stands on it, or None."""
    names = sorted(world.others("table"))
    below = {name: [o for o in (*names, "table") if o != name and _stands_on(world, name, o)] for name in names}
    for name in names:
        group = {name}
        while more := {other for other in names if group & {*below[other]}} - group:
            group |= more
        carriers = {lower for member in group for lower in below[member]} - group
        if not carriers or any(set(below[member]) - group for member in group - {name}):
            continue  # it is carried elsewhere too
        touched = np.concatenate([_touched(world, name, lower) for lower in carriers])
        if len(group) > 1 and len(touched) > 2 and _outside(touched, _center(world, group)) > BESIDE:
            return f"{name} tips with {', '.join(sorted(group - {name})) or 'nothing'} on it"
    return None


def _lowered(T: np.ndarray) -> np.ndarray:
    lower = T.copy()
    lower[2, 3] -= LOWERED
    return lower


def _stands_on(world: World, name: str, other: str) -> bool:
    return (
        depth(world.bodies[name], _lowered(world.poses[name]), world.bodies[other], world.poses[other]) > LOWERED / 3
        and depth(world.bodies[name], world.poses[name], world.bodies[other], world.poses[other]) < LOWERED / 3
    )


def _touched(world: World, name: str, other: str) -> np.ndarray:
    """Points of one body inside another when the first is lowered, and the other way round, from above, (n, 2)."""
    T, T_other = _lowered(world.poses[name]), world.poses[other]
    found = []
    for one, T_one, two, T_two in (
        (world.bodies[name], T, world.bodies[other], T_other),
        (world.bodies[other], T_other, world.bodies[name], T),
    ):
        points = one.points @ T_one[:3, :3].T + T_one[:3, 3]
        found.append(points[within(two, T_two, points), :2])
    return np.concatenate(found)


def _center(world: World, group: set[str]) -> np.ndarray:
    """The common centre of mass of some bodies from above, (2,), by points drawn at random in each."""
    rng, total, moment = np.random.default_rng(0), 0.0, np.zeros(2)
    for name in sorted(group):
        body, T = world.bodies[name], world.poses[name]
        drawn = rng.uniform(*body.box, size=(DRAWN, 3)) @ T[:3, :3].T + T[:3, 3]
        mass = world.task.object(name).mass
        total, moment = total + mass, moment + mass * drawn[within(body, T, drawn), :2].mean(axis=0)
    return moment / total


def _outside(points: np.ndarray, center: np.ndarray) -> float:
    """How far a point lies outside the hull of others [m]; negative inside, or where they span no area."""
    try:
        hull = ConvexHull(points)
    except QhullError:
        return -1.0
    return float((hull.equations[:, :2] @ center + hull.equations[:, 2]).max())
