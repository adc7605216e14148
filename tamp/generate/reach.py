"""The workspace test: whether the robot's hand can come down to where an object stands."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.generate.placement.object_model import Thing, transform
from tamp.task import DEFAULT_ROBOT, load_robot
from tamp.world.kinematics.inverse import inverse
from tamp.world.robot.model import RobotModel, robot_model

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

NEAR, FAR = 0.33, 0.70
"""Distances from the robot's base between which it takes and puts with ease [m]."""
DEPTH = 0.02
"""How deep under its top an object is held [m]."""
LIFT = 0.1
"""How far above that the hand comes from and goes to [m]."""
DOWN = np.diag([1.0, -1.0, -1.0])
"""A tool that points straight down."""


@cache
def _robot() -> RobotModel:
    return robot_model(load_robot(DEFAULT_ROBOT))


@cache
def base() -> tuple[float, float]:
    """Where the robot stands on the table (world frame) [m]."""
    x, y, _ = load_robot(DEFAULT_ROBOT).T_world_base.xyz
    return x, y


def reachable(thing: Thing, T: Matrix) -> bool:
    """Whether the hand, pointing down in one of four turns, reaches a thing at a pose and a lift above it."""
    points = thing.points @ T[:3, :3].T + T[:3, 3]
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, _ = (low + high) / 2
    if not NEAR <= math.dist((x, y), base()) <= FAR:
        return False
    held = max(float(low[2]) + 0.01, float(high[2]) - DEPTH)
    return any(all(_solvable(x, y, held + up, turn) for up in (0.0, LIFT)) for turn in range(4))


def _solvable(x: float, y: float, z: float, turn: int) -> bool:
    c, s = math.cos(turn * math.pi / 4), math.sin(turn * math.pi / 4)
    R = DOWN @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    # The same start for every question: the answer depends on the pose alone.
    return next(iter(inverse(_robot(), transform(R, (x, y, z)), np.random.default_rng(0), count=1)), None) is not None
