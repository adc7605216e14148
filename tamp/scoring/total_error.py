"""How far a table is from what its task asks for, as one length, so that a plan can be judged by what it leaves."""

from __future__ import annotations

from collections.abc import Mapping

from tamp.scoring import score
from tamp.scoring.ede import upper_error_bound
from tamp.task import In, On, Pose, Task


def shortfall(task: Task, poses: Mapping[str, Pose]) -> float:
    """The errors of all goals together [m]: EDE, capped as in the score; a relation that does not hold counts full.

    Args:
        task: what is asked for.
        poses: object -> where it stands (world frame).
    """
    reached = score(task, poses)
    broken = (obj for obj in task.objects if isinstance(obj.goal, On | In) and not reached.goals_met[obj.name])
    return sum(obj.error_m for obj in reached.objects) + sum(upper_error_bound(obj.shape) for obj in broken)
