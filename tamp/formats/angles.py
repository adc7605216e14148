"""Orientations as other people's files have them: roll, pitch, yaw about the fixed axes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from tamp.task.pose import Pose

if TYPE_CHECKING:
    from tamp.task.pose import Vector3

DIGITS = 17
"""What it takes to tell any two numbers apart."""


def roll_pitch_yaw(pose: Pose) -> Vector3:
    """Angles [rad] that give the pose's orientation back: the shortest that do so to the last bit, where there are any.

    A file's rounded angles come out as they were; of others all digits, which give the orientation back to 1e-12.
    """
    roll, pitch, yaw = _angles(pose)
    for digits in range(1, DIGITS):
        rounded = round(roll, digits), round(pitch, digits), round(yaw, digits)
        if Pose.from_rpy(pose.xyz, rounded).quat == pose.quat:
            return rounded
    return roll, pitch, yaw


def _angles(pose: Pose) -> Vector3:
    """Roll first, then the yaw that goes with it: exact also where both turn about nearly the same axis."""
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = (row[:3] for row in pose.matrix[:3].tolist())
    roll, pitch = math.atan2(r21, r22), math.atan2(-r20, math.hypot(r00, r10))
    s, c = math.sin(roll), math.cos(roll)
    return roll, pitch, math.atan2(s * r02 - c * r01, c * r11 - s * r12)
