"""The score of a task: the paper's error per object, its mean, and both baselines beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from tamp.errors import TaskError
from tamp.scoring.ede import ede, mean_edge, upper_error_bound
from tamp.scoring.relations import holds
from tamp.task.mesh import bounds
from tamp.task.model import At, Shape, Task
from tamp.task.pose import Pose

SOLVED_WITHIN_M = 0.03
"""A goal pose counts as reached within this EDE [m]."""


@dataclass(frozen=True)
class ObjectScore:
    """One object with a goal pose.

    Attributes:
        name: the object.
        ede_m: the paper's EDE, not capped; for a lost object without a pose, the bound [m].
        ueb_m: the bound [m].
        error_m: what counts: the smaller of both, the bound for a lost object [m].
        lost: it has fallen off the table, or nobody knows where it is.
    """

    name: str
    ede_m: float
    ueb_m: float
    error_m: float
    lost: bool = False


@dataclass(frozen=True)
class Score:
    """How near the final poses are to the goal.

    Only objects with a goal pose count in the error; goals `on:` and `in:` are met or not, and stand in `goals_met`.

    Attributes:
        ede_m: mean of the objects' errors, the score we rank by; None where no object has a goal pose [m].
        mean_ueb_m: mean of their bounds, the paper's baseline; None likewise [m].
        do_nothing_ede_m: the same error of the task's start poses; None likewise [m].
        improvement: 1 - ede / do-nothing; None where doing nothing is free of error.
        improvement_ueb: 1 - ede / mean UEB.
        objects: one entry an object with a goal pose, in the task's order.
        goals_met: object -> whether its goal holds, poses within 3 cm EDE; objects without a goal are absent.
        lost: objects, with or without a goal, that have fallen off the table.
    """

    ede_m: float | None
    mean_ueb_m: float | None
    do_nothing_ede_m: float | None
    improvement: float | None
    improvement_ueb: float | None
    objects: tuple[ObjectScore, ...]
    goals_met: Mapping[str, bool]
    lost: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "goals_met", MappingProxyType(dict(self.goals_met)))

    @property
    def solved(self) -> bool:
        """Every object with a goal pose within 3 cm EDE of it, every symbolic goal met."""
        return all(self.goals_met.values())

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values."""
        names = ("ede_m", "mean_ueb_m", "do_nothing_ede_m", "improvement", "improvement_ueb")
        return {
            **{name: getattr(self, name) for name in names},
            "solved": self.solved,
            "objects": [vars(o) for o in self.objects],
            "goals_met": dict(self.goals_met),
            "lost": list(self.lost),
        }


def score(task: Task, final_poses: Mapping[str, Pose | None]) -> Score:
    """Score final poses, from whatever source.

    Args:
        task: gives shapes, start poses and goals.
        final_poses: object -> pose in the world frame, or None for an object that is lost.

    Raises:
        TaskError: where an object has no entry, or a mesh cannot be read.
    """
    missing = [o.name for o in task.objects if o.name not in final_poses]
    if missing:
        raise TaskError(f"task {task.name}: the final poses lack {', '.join(missing)}; every object needs one, or None")
    lost = tuple(o.name for o in task.objects if _is_lost(o.shape, final_poses[o.name]))
    objects = _object_scores(task, final_poses)
    idle = _mean([o.error_m for o in _object_scores(task, {o.name: o.pose for o in task.objects})])
    mean, bound = _mean([o.error_m for o in objects]), _mean([o.ueb_m for o in objects])
    return Score(
        ede_m=mean,
        mean_ueb_m=bound,
        do_nothing_ede_m=idle,
        improvement=_improvement(mean, idle),
        improvement_ueb=_improvement(mean, bound),
        objects=objects,
        goals_met=_goals_met(task, objects, {n: p for n, p in final_poses.items() if p is not None}, lost),
        lost=lost,
    )


def _object_scores(task: Task, poses: Mapping[str, Pose | None]) -> tuple[ObjectScore, ...]:
    scores = []
    for o in task.objects:
        if not isinstance(o.goal, At):
            continue
        pose, bound = poses[o.name], upper_error_bound(o.shape)
        error = bound if pose is None else ede(mean_edge(o.shape), pose, o.goal.pose)
        lost = _is_lost(o.shape, pose)
        scores.append(ObjectScore(o.name, error, bound, bound if lost else min(error, bound), lost))
    return tuple(scores)


def _goals_met(
    task: Task, objects: tuple[ObjectScore, ...], poses: Mapping[str, Pose], lost: tuple[str, ...]
) -> dict[str, bool]:
    met = {o.name: not o.lost and o.error_m <= SOLVED_WITHIN_M for o in objects}
    for o in task.objects:
        if o.goal is None or isinstance(o.goal, At):
            continue
        met[o.name] = o.name not in lost and o.goal.target not in lost and holds(task, o.name, o.goal, poses)
    return met


def _is_lost(shape: Shape, pose: Pose | None) -> bool:
    """Whether the centre of the object's bounding box is below the table's face, where nothing on the table can be."""
    if pose is None:
        return True
    lower, upper = bounds(shape)
    x, y, z = (lower + upper) / 2
    return float(pose.matrix[2] @ (x, y, z, 1.0)) < 0.0


def _mean(values: list[float]) -> float | None:
    return sum(values) / len(values) if values else None


def _improvement(error: float | None, baseline: float | None) -> float | None:
    return 1.0 - error / baseline if error is not None and baseline else None
