"""The score of a task: the paper's error per object, its mean, and both baselines beside it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from tamp.frozen import FrozenDict
from tamp.scoring.evaluate import evaluate
from tamp.scoring.metrics import EDE
from tamp.scoring.relations import holds
from tamp.task.expected import expect_task
from tamp.task.model import At, SymbolicFact, Task
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
        goals_met: object -> whether its goal holds, poses within 3 cm EDE; objects without a goal are absent. Symbolic
            facts that the task asks for stand there as PDDL writes them.
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
        object.__setattr__(self, "goals_met", FrozenDict(self.goals_met))

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


def fact_text(fact: SymbolicFact) -> str:
    """A symbolic fact as PDDL writes it, such as "(cooked potato)"; what it is called in `goals_met`."""
    return f"({' '.join(fact)})"


def score(task: Task, final_poses: Mapping[str, Pose | None], facts: Collection[SymbolicFact] | None = None) -> Score:
    """Score final poses, from whatever source.

    Args:
        task: gives shapes, start poses and goals.
        final_poses: object -> pose in the world frame, or None for an object that is lost.
        facts: the symbolic facts that hold in the end; where nobody says, those that the task starts with.

    Raises:
        TaskError: where an object has no entry, or a mesh cannot be read.
    """
    expect_task(task)
    evaluation = evaluate(task, final_poses, EDE)
    objects = tuple(ObjectScore(o.name, o.error, o.bound, o.counted, o.lost) for o in evaluation.objects)
    known = {name: pose for name, pose in final_poses.items() if pose is not None}
    return Score(
        ede_m=evaluation.error,
        mean_ueb_m=evaluation.bound,
        do_nothing_ede_m=evaluation.do_nothing,
        improvement=evaluation.improvement,
        improvement_ueb=evaluation.improvement_bound,
        objects=objects,
        goals_met=_goals_met(task, objects, known, evaluation.lost) | _facts_met(task, facts),
        lost=evaluation.lost,
    )


def _facts_met(task: Task, facts: Collection[SymbolicFact] | None) -> dict[str, bool]:
    known = task.init if facts is None else facts
    return {fact_text(fact): fact in known for fact in task.goal}


def _goals_met(
    task: Task, objects: tuple[ObjectScore, ...], poses: Mapping[str, Pose], lost: tuple[str, ...]
) -> dict[str, bool]:
    met = {o.name: not o.lost and o.error_m <= SOLVED_WITHIN_M for o in objects}
    for o in task.objects:
        if o.goal is None or isinstance(o.goal, At):
            continue
        met[o.name] = o.name not in lost and o.goal.target not in lost and holds(task, o.name, o.goal, poses)
    return met
