"""The baseline: does nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tamp.contest.api.client import Goal, Robot


class Solution:
    """Leaves everything where it is."""

    def run(self, goal: Goal, robot: Robot) -> None:
        """Do nothing."""
        print(f"{goal.task}: {len(goal.objects)} objects, {robot.time_left:.0f} s; nothing is done")
