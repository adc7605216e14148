"""What is clearly wrong with an object that is pushed over one of its edges."""

from __future__ import annotations

import numpy as np

from tamp.task import Move
from tests.checking.oracle.bodies import links_along, robot, tool_at
from tests.checking.oracle.pushes import fingers_at
from tests.checking.oracle.world import World, rests

SLIDES = 0.01  # the edge goes no further than this, along the table or off it [m]
MARGIN = 2.0  # more friction than this many times what there is, no object has
SHORT = 0.01  # of its edge, the middle of what falls over it is no farther than this [m]


def topple(world: World, move: Move) -> str | None:
    """The object turns over its edge ahead as the hand takes it, until it falls; why it does not, or None."""
    if move.pushed is None:
        return None
    name, T_tool_object, q = move.pushed.object, move.pushed.T_tool_object.matrix, move.trajectory.positions
    if np.linalg.norm((tool_at(q[0]) @ T_tool_object - world.poses[name])[:3, 3]) > 0.006:
        return f"{name} is not where the push begins"
    riders = [other for other in world.others(name, "table") if rests(world, other) is None]
    fingers = fingers_at(world, move, name)
    if not fingers:
        return f"no finger is at {name}"
    before, after = world.poses[name], tool_at(q[-1]) @ T_tool_object
    starts, ends = (world.bodies[name].points @ T[:3, :3].T + T[:3, 3] for T in (before, after))
    ahead = (ends - starts).mean(axis=0)[:2]
    ahead /= max(np.linalg.norm(ahead), 1e-9)
    low = starts[starts[:, 2] < starts[:, 2].min() + 0.002]
    edge = (starts[:, 2] < starts[:, 2].min() + 0.002) & (starts[:, :2] @ ahead > (low[:, :2] @ ahead).max() - 0.002)
    if np.linalg.norm(ends[edge] - starts[edge], axis=1).min() > SLIDES:
        return f"the edge that {name} turns about does not stay"
    if (ends.mean(axis=0)[:2] - ends[edge].mean(axis=0)[:2]) @ ahead < -SHORT:
        return f"{name} falls back"
    lever = ((starts[edge].mean(axis=0) - starts.mean(axis=0))[:2]) @ ahead
    placed, _ = links_along(q[:1], move.opening)
    height = min(_lowest(placed[finger][0], robot()[2][finger].points) for finger in fingers)
    if lever > MARGIN * world.task.object(name).friction * height:
        return f"{name} slides away"
    world.poses[name] = after
    return rests(world, name) or next((text for o in riders if (text := rests(world, o)) is not None), None)


def _lowest(T: np.ndarray, points: np.ndarray) -> float:
    return float((points @ T[2, :3] + T[2, 3]).min())
