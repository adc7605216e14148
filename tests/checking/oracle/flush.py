"""Do closing pads turn a box that they grip askew, from above or from a side, into what stands near its ends?"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from tamp.task import Box, Gripper, Object
from tamp.task.robot import PAD_FRICTION
from tests.checking.oracle.bodies import Body, depth

ASKEW = (0.05, 0.25)  # so far a box is turned until it lies flush [rad]
SQUARE = 0.02  # what is turned no farther about any other axis [rad]
INTO = 0.003  # deeper than that it is turned into what it did not touch [m]


def turned_into(
    thing: Object, gripper: Gripper, T_tool: np.ndarray, bodies: Mapping[str, Body], poses: Mapping[str, np.ndarray]
) -> str | None:
    """Name of what a box meets as it is turned; `poses` are those of the box and of all that stands."""
    if not isinstance(thing.shape, Box):
        return None
    T = np.linalg.inv(T_tool) @ poses[thing.name]
    along, beside = np.array(gripper.axis), np.cross((0.0, 0.0, 1.0), gripper.axis)
    k = int(np.abs(along @ T[:3, :3]).argmax())
    normal = T[:3, k] * np.sign(along @ T[:3, k])
    angle = float(np.arctan2(normal @ beside, normal @ along))
    sticks = 1.2 * PAD_FRICTION * thing.friction * thing.shape.size[k] > gripper.pad[1]
    if not ASKEW[0] < abs(angle) < ASKEW[1] or abs(normal[2]) > SQUARE or sticks:
        return None
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_rotvec([0.0, 0.0, -angle]).as_matrix()
    there = T_tool @ turn @ T
    for other in sorted(poses.keys() - {thing.name, "table"}):
        pair = bodies[other], poses[other]
        if depth(bodies[thing.name], poses[thing.name], *pair) < 0.0 and depth(bodies[thing.name], there, *pair) > INTO:
            return other
    return None
