"""What a perceiver says of an object."""

from __future__ import annotations

from dataclasses import dataclass

from tamp.task.pose import Pose


@dataclass(frozen=True)
class Estimate:
    """Where an object is thought to be.

    Attributes:
        pose: T_world_object; None is "not seen".
        confidence: 0..1; 0 where it was not seen.
        alternatives: further poses that the pictures allow, the best first.
    """

    pose: Pose | None
    confidence: float
    alternatives: tuple[Pose, ...] = ()
