"""Task and motion planning for a robot arm at a cluttered table.

    task = tamp.load_task("scenarios/swap.yaml")
    plan = tamp.plan(task, seed=0, timeout=60.0)
    run = tamp.execute(task, plan, seed=0)
    score = tamp.score(task, run.final_poses)
    result = tamp.solve(task, seed=0, timeout=60.0)

Names load on first use, so that `import tamp` stays instant and touches no native library.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tamp.checking import Verdict, check
    from tamp.errors import (
        DomainError,
        PlanError,
        PlanningFailure,
        RobotError,
        SamplerError,
        TampError,
        TaskError,
    )
    from tamp.execution.executor import execute
    from tamp.execution.record import Execution
    from tamp.pipeline.planning import plan
    from tamp.pipeline.solving import solve
    from tamp.results import Result
    from tamp.scoring import Score, score
    from tamp.streams.values import Grasp
    from tamp.task import (
        At,
        Box,
        Capsule,
        Cylinder,
        In,
        Limits,
        Mesh,
        Object,
        On,
        Plan,
        Pose,
        Region,
        Sphere,
        Table,
        Task,
    )
    from tamp.task.load import load_task
    from tamp.task.plan_file import load_plan, save_plan
    from tamp.task.save import save_task

_HOMES = {
    "tamp.checking": ("Verdict", "check"),
    "tamp.errors": (
        "DomainError", "PlanError", "PlanningFailure", "RobotError", "SamplerError", "TampError", "TaskError",
    ),
    "tamp.execution.executor": ("execute",),
    "tamp.execution.record": ("Execution",),
    "tamp.pipeline.planning": ("plan",),
    "tamp.pipeline.solving": ("solve",),
    "tamp.results": ("Result",),
    "tamp.scoring": ("Score", "score"),
    "tamp.streams.values": ("Grasp",),
    "tamp.task": (
        "At", "Box", "Capsule", "Cylinder", "In", "Limits", "Mesh", "Object", "On", "Plan", "Pose", "Region", "Sphere",
        "Table", "Task",
    ),
    "tamp.task.load": ("load_task",),
    "tamp.task.plan_file": ("load_plan", "save_plan"),
    "tamp.task.save": ("save_task",),
}  # fmt: skip
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "At", "Box", "Capsule", "Cylinder", "DomainError", "Execution", "Grasp", "In", "Limits", "Mesh", "Object", "On",
    "Plan", "PlanError", "PlanningFailure", "Pose", "Region", "Result", "RobotError", "SamplerError", "Score", "Sphere",
    "Table", "TampError", "Task", "TaskError", "Verdict", "check", "execute", "load_plan", "load_task", "plan",
    "save_plan", "save_task", "score", "solve",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'tamp' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
