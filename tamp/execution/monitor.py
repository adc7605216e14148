"""Comparing what is with what was meant."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tamp.execution.log import Deviation, Kind
from tamp.task import Pose

MOVED, TURNED = 0.003, 0.05
"""What is off by less than both of these is where the plan has it, wherever it matters [m, rad]."""


@dataclass(frozen=True)
class Monitor:
    """How far an object may be from where the plan has it before the plan is given up.

    Attributes:
        position: [m].
        angle: [rad].
        slip: how far a held object may move in the tool frame [m].
        slip_angle: [rad].
    """

    position: float = 0.01
    angle: float = 0.25
    slip: float = 0.02
    slip_angle: float = 0.5

    def compare(
        self, expected: Mapping[str, Pose], actual: Mapping[str, Pose], placed: Iterable[str]
    ) -> tuple[Deviation, ...]:
        """Deviations over the tolerance, the largest distance first.

        Args:
            expected: object -> pose as the plan has it; objects absent here are not compared.
            actual: object -> pose as it is.
            placed: objects that the last action set down.
        """
        found, placed = [], set(placed)
        for name, pose in expected.items():
            kind: Kind = "misplaced" if name in placed else "disturbed"
            off = deviation(name, kind, pose, actual[name])
            if off.distance > self.position or off.angle > self.angle:
                found.append(off)
        return tuple(sorted(found, key=lambda d: (-d.distance, d.object)))

    def slipped(self, name: str, expected: Pose, actual: Pose) -> Deviation | None:
        """The deviation of a held object, both poses in the tool frame, where it is over the tolerance."""
        off = deviation(name, "slipped", expected, actual)
        return off if off.distance > self.slip or off.angle > self.slip_angle else None


def deviation(name: str, kind: Kind, expected: Pose, actual: Pose) -> Deviation:
    """How far `actual` is from `expected`, both in the same frame."""
    return Deviation(name, kind, math.dist(expected.xyz, actual.xyz), angle_between(expected, actual))


def is_off(found: Deviation) -> bool:
    """Whether an object is so far from where the plan has it that what keeps clear of it there may not keep clear."""
    return found.distance >= MOVED or found.angle >= TURNED


def angle_between(a: Pose, b: Pose) -> float:
    """The angle of the rotation that takes one orientation to the other [rad], in 0..pi."""
    dot = abs(sum(x * y for x, y in zip(a.quat, b.quat, strict=True)))
    cross = math.sqrt(max(0.0, 1.0 - dot * dot))
    return 2.0 * math.atan2(cross, dot)
