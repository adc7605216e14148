"""The line of blocks with moves that must not hit anything: a path may be blocked by what stands in its way.

As in PDDLStream's continuous examples a region is tested as well as sampled from, moves cost their distance, and
whether a path is free depends on the state.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.planning import Problem
from tests.planning.problems import continuous
from tests.planning.problems.continuous import Array

DOMAIN = (
    continuous.DOMAIN.replace(continuous.UNSAFE, continuous.FORALL)
    .replace("(UnsafePose ?b ?p))", "(UnsafePose ?b ?p) (TrajCollision ?t ?b ?p) (UnsafeTraj ?t) (Unsafe))", 1)
    .replace("(AtConf ?q1) (CanMove))", "(AtConf ?q1) (CanMove) (not (Unsafe)) (not (UnsafeTraj ?t)))")
    .replace("(not (CanMove)))", "(not (CanMove)) (increase (total-cost) (Distance ?q1 ?q2)))")
    .replace("(:action move", "(:functions (Distance ?q1 ?q2))\n  (:action move")
    .replace(
        "(:derived (In",
        """(:derived (UnsafeTraj ?t)
    (exists (?b2 ?p2) (and (Traj ?t) (Pose ?b2 ?p2) (AtPose ?b2 ?p2) (TrajCollision ?t ?b2 ?p2))))
  (:derived (In""",
    )
)

STREAMS = (
    continuous.STREAMS.rstrip()[:-1]
    + """
  (:function (Distance ?q1 ?q2) (and (Conf ?q1) (Conf ?q2)))
  (:predicate (TrajCollision ?t ?b ?p) (and (Traj ?t) (Pose ?b ?p)))
  (:stream test-region
    :inputs (?b ?p ?r)
    :domain (and (Pose ?b ?p) (Placeable ?b ?r))
    :certified (Contained ?b ?p ?r)))
"""
)


def plan_motion(context: Any, start: Array, end: Array) -> Iterator[Array]:
    """Straight at the height of the blocks' tops, then over them."""
    for height in (1.0, 2.0):
        yield np.array([start, [*start[:-1], height], [*end[:-1], height], end])


def trajcollision(context: Any, path: Array, block: str, pose: Array) -> bool:
    """Whether a path as low as the blocks passes over one."""
    low, high = sorted((path[0][0], path[-1][0]))
    return bool(path[1][-1] < 2.0 and low < pose[0] < high)


SAMPLERS = {
    **continuous.SAMPLERS,
    "plan-motion": plan_motion,
    "trajcollision": trajcollision,
    "distance": lambda context, a, b: float(np.abs(a - b).sum()),
}


def line(n: int) -> Problem:
    """n blocks at height 0 side by side; all must come into the region left of them, and the hand back."""
    regions = {
        "table": (np.array([-1.0, -0.5]), np.array([n + 1.0, 0.5])),
        "goal": (np.array([-2.0 * n - 2.0, -0.5]), np.array([-1.0, 0.5])),
    }

    def test_region(context: Any, block: str, pose: Array, region: str) -> bool:
        lower, upper = regions[region]
        return bool(np.all(lower <= pose - 0.5) and np.all(pose + 0.5 <= upper))

    home = np.array([2.0 * n, 1.0])
    blocks = [f"b{i}" for i in range(n)]
    init: list[Any] = [("HandEmpty",), ("CanMove",), ("Conf", home), ("AtConf", home)]
    for i, block in enumerate(blocks):
        pose = np.array([i + 0.5, 0.0])
        init += [("Block", block), ("Pose", block, pose), ("AtPose", block, pose)]
        init += [("Placeable", block, region) for region in regions]
    goal = ("and", ("HandEmpty",), ("AtConf", home), *(("In", block, "goal") for block in blocks))
    samplers = {**SAMPLERS, "test-region": test_region}
    return Problem(domain=DOMAIN, streams=STREAMS, samplers=samplers, init=init, goal=goal, scene=regions)
