"""Whether an object that turned between the fingers can be carried on as it lies in the hand now."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.task import Attachment, Move, Pose, Step
from tamp.world.world import World

if TYPE_CHECKING:
    from numpy.typing import NDArray

STRIDE = 0.05  # between the configurations that are looked at, in the joint that moves farthest [rad]
GRAZE = 0.002  # how deep the object may come into another on its way [m]


def can_carry(world: World, poses: Mapping[str, Pose], held: Attachment, steps: Sequence[Step]) -> bool:
    """Whether a held object meets no other object until it is let go.

    The table does not count: an object that comes down on it askew turns back between the fingers.

    Args:
        world: robot and objects.
        poses: object -> pose (world frame) of all objects, as they are.
        held: the object, as it lies in the hand.
        steps: what is still to be done; it ends where nothing is held any more.
    """
    others = {name: poses[name].matrix for name in sorted(poses) if name != held.object}
    tools = (world.robot.forward(q) for q in _configurations(steps))
    ways = (tool @ held.T_tool_object.matrix for tool in tools)
    return not any(
        world.overlap(held.object, T_held, other, T_other, tolerance=GRAZE)
        for T_held in ways
        for other, T_other in others.items()
    )


def _configurations(steps: Sequence[Step]) -> Iterator[NDArray[np.float64]]:
    """Arm configurations on the way to where the object is let go, not far apart, each way's last among them [rad]."""
    for step in steps:
        if not isinstance(step, Move) or step.held is None:
            return
        last = step.trajectory.positions[0]
        yield last
        for q in step.trajectory.positions[1:]:
            if np.abs(q - last).max() > STRIDE:
                last = q
                yield q
        yield step.trajectory.positions[-1]
