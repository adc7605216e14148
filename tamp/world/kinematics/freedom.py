"""Whether an arm can move and turn its tool every way: one of five joints cannot, nor one of parallel axes."""

from __future__ import annotations

from functools import cache

import numpy as np

from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

CONFIGURATIONS = 20
"""So many are looked at, since a single one may be singular."""
NONE = 1e-6
"""A direction in which the tool moves by less for a unit of motion of the joints is none [m or rad]."""


@cache
def confined(robot: RobotModel) -> bool:
    """Whether the tool has fewer than six degrees of freedom wherever the arm is.

    However near, nearly all tool poses are out of the reach of such an arm: those that it takes are a thin set, which a
    pose that is drawn at random misses. Those from straight above are the ones to look for.
    """
    rng = np.random.default_rng(0)
    q = rng.uniform(robot.lower, robot.upper, (CONFIGURATIONS, robot.dof))
    arm = chain(robot)
    frames = arm.frames(q)
    tool = (frames[-1] @ arm.tool)[:, :3, 3]
    along = np.einsum("nbij,nj->nbi", frames[:, :, :3, :3], arm.axis)
    turns = ~arm.slides[:, None, None]
    moves = np.where(turns, np.cross(along, tool - frames[:, :, :3, 3]), along)
    jacobians = np.concatenate([moves, np.where(turns, along, 0.0)], axis=2).transpose(1, 2, 0)
    return bool((np.linalg.matrix_rank(jacobians, tol=NONE) < 6).all())
