"""Final poses against goal poses by any of the metrics, with both baselines beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.errors import TaskError
from tamp.scoring.assignment import best_assignment
from tamp.scoring.metrics import OCRTOC_2024, Metric
from tamp.scoring.ocrtoc2024 import THRESHOLDS
from tamp.task.mesh.parts import bounds
from tamp.task.model import At, Object, Shape, Task
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

Poses = Mapping[str, Pose | None]

EXPECTED = "expected a mapping of object names to tamp.Pose, such as Pose.from_matrix(T) makes, or None"


@dataclass(frozen=True)
class ObjectError:
    """One object with a goal pose.

    Attributes:
        name: the object.
        error: as the metric has it, not capped; for an object whose pose nobody knows, the bound.
        bound: the most it may count for.
        counted: what it counts for; the bound for a lost object.
        lost: it has fallen off the table, or nobody knows where it is.
        goal_of: the object whose goal it is held against: itself, or another of its shape.
    """

    name: str
    error: float
    bound: float
    counted: float
    lost: bool
    goal_of: str


@dataclass(frozen=True)
class Evaluation:
    """What a metric says of final poses. The numbers are None where no object has a goal pose.

    Attributes:
        metric: its name.
        unit: of `error`, `bound` and `do_nothing`: "m", or "" for a share.
        error: mean of what the objects count for.
        bound: mean of the most they may count for: the paper's baseline.
        do_nothing: the same error of the task's start poses.
        improvement: 1 - error / do_nothing; None where doing nothing is free of error.
        improvement_bound: 1 - error / bound.
        objects: one entry an object with a goal pose, in the task's order.
        lost: objects, with or without a goal, that have fallen off the table.
    """

    metric: str
    unit: str
    error: float | None
    bound: float | None
    do_nothing: float | None
    improvement: float | None
    improvement_bound: float | None
    objects: tuple[ObjectError, ...]
    lost: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values; for `ocrtoc2024` also `in_place`, the share of objects over each threshold of overlap."""
        return asdict(self) | ({"in_place": self.in_place()} if self.metric == OCRTOC_2024.name else {})

    def in_place(self) -> dict[str, float]:
        """Share of objects whose error is below 1 - threshold, for each threshold; of use for `ocrtoc2024` only."""
        return {
            str(threshold): sum(not o.lost and o.error < 1.0 - threshold for o in self.objects) / len(self.objects)
            for threshold in THRESHOLDS
            if self.objects
        }


def evaluate(task: Task, final_poses: Poses, metric: Metric) -> Evaluation:
    """Hold final poses, from whatever source, against the goal poses.

    Args:
        task: gives shapes, symmetries, start poses and goals.
        final_poses: object -> pose in the world frame, or None for an object that is lost.
        metric: see `tamp.scoring.metrics`.

    Raises:
        TaskError: where an object has no entry, or one that is no pose, or a mesh cannot be read.
    """
    if not isinstance(final_poses, Mapping):
        raise TaskError(f"task {task.name}: the final poses are a {type(final_poses).__name__}; {EXPECTED}")
    missing = [o.name for o in task.objects if o.name not in final_poses]
    if missing:
        raise TaskError(f"task {task.name}: the final poses lack {', '.join(missing)}; every object needs one, or None")
    for o in task.objects:
        if not isinstance(final_poses[o.name], Pose | None):
            kind = type(final_poses[o.name]).__name__
            raise TaskError(f"task {task.name}: the final pose of {o.name} is a {kind}; {EXPECTED}")
    objects = _errors(task, final_poses, metric)
    idle = _mean([o.counted for o in _errors(task, {o.name: o.pose for o in task.objects}, metric)])
    error, bound = _mean([o.counted for o in objects]), _mean([o.bound for o in objects])
    return Evaluation(
        metric=metric.name,
        unit=metric.unit,
        error=error,
        bound=bound,
        do_nothing=idle,
        improvement=improvement(error, idle),
        improvement_bound=improvement(error, bound),
        objects=objects,
        lost=tuple(o.name for o in task.objects if _is_lost(o.shape, final_poses[o.name])),
    )


def improvement(error: float | None, baseline: float | None) -> float | None:
    """1 - error / baseline; None where either is unknown or the baseline is zero."""
    return 1.0 - error / baseline if error is not None and baseline else None


def _errors(task: Task, poses: Poses, metric: Metric) -> tuple[ObjectError, ...]:
    found: dict[str, ObjectError] = {}
    for group in _groups(task, metric):
        found |= {o.name: o for o in _group_errors(group, poses, metric)}
    return tuple(found[o.name] for o in task.objects if o.name in found)


def _groups(task: Task, metric: Metric) -> list[list[Object]]:
    """Objects with a goal pose, those together that may take each other's goals."""
    groups: dict[Any, list[Object]] = {}
    for o in task.objects:
        if isinstance(o.goal, At):
            groups.setdefault((o.shape, o.symmetry) if metric.interchange else o.name, []).append(o)
    return list(groups.values())


def _group_errors(group: list[Object], poses: Poses, metric: Metric) -> list[ObjectError]:
    lost = [_is_lost(o.shape, poses[o.name]) for o in group]
    errors = np.array([[_error(o, poses[o.name], other, metric) for other in group] for o in group])
    bounds_ = [metric.bound(o) for o in group]
    chosen = best_assignment(_costs(errors, bounds_, lost)) if len(group) > 1 else (0,)
    return [
        ObjectError(
            name=o.name,
            error=float(errors[i, j]),
            bound=bounds_[i],
            counted=bounds_[i] if lost[i] else metric.counted(float(errors[i, j]), bounds_[i]),
            lost=lost[i],
            goal_of=group[j].name,
        )
        for i, (o, j) in enumerate(zip(group, chosen, strict=True))
    ]


def _error(o: Object, pose: Pose | None, other: Object, metric: Metric) -> float:
    assert isinstance(other.goal, At)
    return metric.bound(o) if pose is None else metric.error(o, pose, other.goal.pose)


def _costs(errors: NDArray[np.float64], bounds_: list[float], lost: list[bool]) -> NDArray[np.float64]:
    """Errors capped at the bound, which is what a lost object costs everywhere; shape (n, n)."""
    limit = np.array(bounds_)[:, None]
    return np.where(np.array(lost)[:, None], limit, np.minimum(errors, limit))


def _is_lost(shape: Shape, pose: Pose | None) -> bool:
    """Whether the centre of the object's bounding box is below the table's face, where nothing on the table can be."""
    if pose is None:
        return True
    lower, upper = bounds(shape)
    x, y, z = (lower + upper) / 2
    return float(pose.matrix[2] @ (x, y, z, 1.0)) < 0.0


def _mean(values: list[float]) -> float | None:
    return sum(values) / len(values) if values else None
