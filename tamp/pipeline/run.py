"""Everything that a run left behind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tamp.errors import PlanningFailure
from tamp.execution.record import Execution
from tamp.results import Result
from tamp.task import Plan, Pose


@dataclass(frozen=True)
class Run:
    """Everything a run left behind.

    Attributes:
        result: the record.
        plans: all plans, in order.
        executions: one for each plan that was carried out.
        final_poses: object -> pose (world frame) at the end.
        failure: why planning gave up the last time, or None.
        rejections: the verdict on each piece of a plan that the checker sent back.
    """

    result: Result
    plans: tuple[Plan, ...]
    executions: tuple[Execution, ...]
    final_poses: Mapping[str, Pose]
    failure: PlanningFailure | None = None
    rejections: tuple[str, ...] = ()
