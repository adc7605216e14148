"""All ways in which an object may be let go above a placement, to fall to it: straight down, or from a tilt."""

from __future__ import annotations

import math

from tamp.streams.dropping import drops
from tamp.streams.tilting import layable, tilts
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose

EACH = 3  # which of the drops, one of so many, tell whether a grasp can let an object fall at all
SIEVING_TILTS = (20, 30, 45, 60)  # that tell whether a grasp can lay an object down at all [degrees]


def may_fall(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether a hand that puts an object down at its goal may be in its own way, and there is another way down."""
    return placement is workspace.goals.get(obj) and bool(
        drops(workspace, obj, placement) or layable(workspace, obj, placement)
    )


def letting_go(workspace: Workspace, obj: str, placement: Placement) -> list[Pose]:
    """Poses from which an object falls to its goal, the lowest first, a few that stand for all; none for another."""
    if not may_fall(workspace, obj, placement):
        return []
    above = [fall[0] for fall in drops(workspace, obj, placement)[EACH - 1 :: EACH]]
    if not layable(workspace, obj, placement):
        return above
    found = tilts(workspace, obj, placement)
    return above + [tilt.fall[0] for tilt in found if round(math.degrees(tilt.angle)) in SIEVING_TILTS]
