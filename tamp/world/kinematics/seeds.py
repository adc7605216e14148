"""Where to start inverse kinematics: configurations known to put the tool near the wanted pose, in rounds.

The starts are the nearest of a table of random configurations. They already know the arm, two in three converge, and
since the table is uniform in joint space they spread over the family of solutions of a redundant arm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.world.kinematics.levenberg_marquardt import METRES_PER_RADIAN
from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

TABLE_SIZE = 50_000
FAR = 0.3
"""A pose farther than this from all of the table's is out of reach [m]; of reachable ones none was beyond 0.23."""


@dataclass(frozen=True, slots=True)
class Round:
    """One round of starts.

    Attributes:
        starts: how many.
        patience: after how many iterations a start that no longer halves its error is dropped.
        despair: where nothing has been found and every start stayed farther than this [m], the search ends.
    """

    starts: int
    patience: int
    despair: float


ROUNDS = (
    Round(12, 5, 0.12),
    Round(24, 8, 0.08),
    Round(48, 12, 0.05),
    Round(96, 25, 0.02),
    Round(192, 25, 0.0),
)


@dataclass(frozen=True, eq=False)
class _SeedTable:
    """Random configurations, and a tree over their tool poses."""

    configurations: Array
    tree: Any


@cache
def _seed_table(robot: RobotModel) -> _SeedTable:
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(0)
    q = rng.uniform(*one_turn(robot), (TABLE_SIZE, robot.dof))
    features = np.concatenate([_features(*chain(robot).forward(block)) for block in np.array_split(q, 20)])
    return _SeedTable(q, cKDTree(features))


def one_turn(robot: RobotModel) -> tuple[Array, Array]:
    """Lower and upper ends of what joints need to reach all that they can: their limits, or a turn about home [rad]."""
    wide = robot.upper - robot.lower > 2 * math.pi
    lower = np.where(wide, np.maximum(robot.lower, robot.home - math.pi), robot.lower)
    upper = np.where(wide, np.minimum(robot.upper, robot.home + math.pi), robot.upper)
    return lower, upper


def _features(R: Array, p: Array) -> Array:
    """Tool poses as points whose distances are metres of motion, shape (b, 9): position and two of the tool's axes."""
    weight = METRES_PER_RADIAN / math.sqrt(2)
    return np.concatenate([p, weight * R[:, :, 0], weight * R[:, :, 2]], axis=1)


def nearest_starts(robot: RobotModel, T_world_tools: Array, count: int) -> Array:
    """The table's nearest configurations to each of many tool poses (n, 4, 4); shape (n, count, dof) [rad]."""
    table = _seed_table(robot)
    _, nearest = table.tree.query(_features(T_world_tools[:, :3, :3], T_world_tools[:, :3, 3]), k=count)
    found: Array = table.configurations[nearest]
    return found


def rounds_of_starts(
    robot: RobotModel, T_world_tool: Array, rng: np.random.Generator, near: Array | None, count: int
) -> Iterator[tuple[Array, Round]]:
    """The starts of each round: around `near`, then the table's next nearest, shuffled within a round.

    The first round is large enough to yield `count` solutions as a rule: one large batch costs less than two small.
    """
    table = _seed_table(robot)
    point = _features(T_world_tool[None, :3, :3], T_world_tool[None, :3, 3])[0]
    size = min(3 * max(count, 4), 48)
    distance, nearest = table.tree.query(point, k=size)
    if distance[0] > FAR:
        return
    if near is not None:
        yield np.concatenate([near[None], near + rng.normal(0.0, 0.2, (3, robot.dof))]), Round(4, 4, np.inf)
    yield table.configurations[rng.permutation(nearest)], Round(size, 4, 0.15)
    for effort in ROUNDS:
        _, nearest = table.tree.query(point, k=size + effort.starts)
        yield table.configurations[rng.permutation(nearest[size:])], effort
        size += effort.starts
