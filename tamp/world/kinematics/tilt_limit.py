"""How far a hand can point up at each height over a table that the arm behind it stays above.

A capability map (Zacharias, Borst and Hirzinger, IROS 2007) of a table that is endless: what depends on where the hand
is and on its heading is left out. It answers for thousands of hands at once what inverse kinematics would find out for
each of them, with one configuration after the other reaching into the table.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.cache import cached, content_key
from tamp.world.kinematics.seeds import one_turn
from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SAMPLES, BLOCK = 200_000, 20_000
LOWEST, HIGHEST, STEP = -0.05, 0.55, 0.01  # of the heights that are told apart [m]
FEW = 100  # configurations at a height that tell too little of it
SPARE = np.radians(3.0)  # that a sample may have missed [rad]


@dataclass(frozen=True, eq=False)
class TiltLimit:
    """The most that a tool may be tilted, by its height.

    Attributes:
        tilts: largest angles between a tool's approach direction and straight down, one for each height from LOWEST on,
            STEP apart, shape (n,) [rad].
        behind: how far the last but one of the arm's joints, or its only one, is from the tool, at most [m].
    """

    tilts: Array
    behind: float

    def keeps_arm_up(self, T_world_tools: Array) -> NDArray[np.bool_]:
        """Whether an arm may hold each of many tools (m, 4, 4) and be above the plane z = 0, were the plane endless."""
        index = ((T_world_tools[:, 2, 3] - LOWEST) / STEP).astype(np.int64)
        most = self.tilts[np.clip(index, 0, len(self.tilts) - 1)]
        allowed: NDArray[np.bool_] = -T_world_tools[:, 2, 2] >= np.cos(most)
        return allowed


@cache
def tilt_limit(robot: RobotModel) -> TiltLimit:
    """The limit of a robot that stands where its data say; above all heights that are told apart there is none."""
    hulls = b"".join(body.hull.vertices.tobytes() + bytes([body.joint]) for body in robot.bodies)
    key = content_key("tilt-limit-3", robot.spec.description.encode(), hulls, repr(robot.spec))
    stored = cached("tilt-limit", key, lambda: _sampled(robot))
    return TiltLimit(np.asarray(stored["tilts"], np.float64), float(stored["behind"]))


def _sampled(robot: RobotModel) -> dict[str, Array]:
    """The same as arrays, from random configurations: the most tilted of those whose links are above the plane."""
    rng, ends = np.random.default_rng(0), one_turn(robot)
    count = round((HIGHEST - LOWEST) / STEP)
    tilts, met, behind = np.zeros(count), np.zeros(count, np.int64), 0.0
    for _ in range(SAMPLES // BLOCK):
        frames = chain(robot).frames(rng.uniform(*ends, (BLOCK, robot.dof)))
        tools = frames[-1] @ chain(robot).tool
        behind = max(behind, float(np.linalg.norm(tools[:, :3, 3] - frames[-2:][0, :, :3, 3], axis=1).max()))
        low = np.flatnonzero((tools[:, 2, 3] > LOWEST) & (tools[:, 2, 3] < HIGHEST))
        above = low[_lowest(robot, frames[:, low]) > 0.0]
        index = ((tools[above, 2, 3] - LOWEST) / STEP).astype(np.int64)
        np.add.at(met, index, 1)
        np.maximum.at(tilts, index, np.arccos(np.clip(-tools[above, 2, 2], -1.0, 1.0)))
    most = np.where(met < FEW, np.pi, np.minimum(tilts + SPARE, np.pi))
    return {"tilts": np.append(most, np.pi), "behind": np.array(behind)}


def _lowest(robot: RobotModel, frames: Array) -> Array:
    """How high the lowest point of the arm is, without base and hand, by joint frames (joints, m, 4, 4); (m,) [m]."""
    order = {robot.model.getJointId(name): index for index, name in enumerate(robot.spec.joints)}
    lowest = np.full(frames.shape[1], np.inf)
    for index, body in enumerate(robot.bodies):
        if index not in robot.hand and body.joint in order:
            T = frames[order[body.joint]]
            lowest = np.minimum(lowest, (T[:, 2, :3] @ body.hull.vertices.T).min(axis=1) + T[:, 2, 3])
    return lowest
