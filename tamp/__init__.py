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
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str

    from tamp.checking import Verdict
    from tamp.errors import (
        DomainError,
        PartError,
        PlanError,
        PlanningFailure,
        PlanRefusedError,
        RobotError,
        SamplerError,
        TampError,
        TaskError,
    )
    from tamp.execution.log import Execution
    from tamp.pipeline.check import check
    from tamp.pipeline.execute import execute
    from tamp.pipeline.notebook import prepare, sampler_context
    from tamp.pipeline.plan import plan
    from tamp.pipeline.solving.solve import solve
    from tamp.results import Result
    from tamp.scoring import Score, score
    from tamp.streams.values import Grasp
    from tamp.task import (
        Action,
        At,
        Box,
        Capsule,
        Cylinder,
        Fall,
        Grip,
        In,
        Limits,
        Mesh,
        Move,
        Object,
        On,
        Plan,
        Pose,
        Region,
        Release,
        Sphere,
        Table,
        Task,
        Trajectory,
    )
    from tamp.task.files.load import load_task
    from tamp.task.files.plan_file import load_plan, save_plan
    from tamp.task.files.save import save_task

_HOMES = {
    "tamp.checking": ("Verdict",),
    "tamp.errors": (
        "DomainError", "PartError", "PlanError", "PlanRefusedError", "PlanningFailure", "RobotError", "SamplerError",
        "TampError", "TaskError",
    ),
    "tamp.execution.log": ("Execution",),
    "tamp.pipeline.check": ("check",),
    "tamp.pipeline.execute": ("execute",),
    "tamp.pipeline.notebook": ("prepare", "sampler_context"),
    "tamp.pipeline.plan": ("plan",),
    "tamp.pipeline.solving.solve": ("solve",),
    "tamp.results": ("Result",),
    "tamp.scoring": ("Score", "score"),
    "tamp.streams.values": ("Grasp",),
    "tamp.task": (
        "Action", "At", "Box", "Capsule", "Cylinder", "Fall", "Grip", "In", "Limits", "Mesh", "Move", "Object", "On",
        "Plan", "Pose", "Region", "Release", "Sphere", "Table", "Task", "Trajectory",
    ),
    "tamp.task.files.load": ("load_task",),
    "tamp.task.files.plan_file": ("load_plan", "save_plan"),
    "tamp.task.files.save": ("save_task",),
}  # fmt: skip
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "Action", "At", "Box", "Capsule", "Cylinder", "DomainError", "Execution", "Fall", "Grasp", "Grip", "In", "Limits",
    "Mesh", "Move", "Object", "On", "PartError", "Plan", "PlanError", "PlanRefusedError", "PlanningFailure", "Pose",
    "Region", "Release", "Result", "RobotError", "SamplerError", "Score", "Sphere", "Table", "TampError", "Task",
    "TaskError", "Trajectory", "Verdict", "check", "execute", "load_plan", "load_task", "plan", "prepare",
    "sampler_context", "save_plan", "save_task", "score", "solve",
]  # fmt: skip


if not TYPE_CHECKING:  # a type checker shall refuse a name that is not there

    def __getattr__(name: str) -> Any:
        if name == "__version__":
            return importlib.import_module("tamp.versions").versions()["tabletop-tamp"]
        if name not in _HOME:  # Python itself adds what was probably meant
            raise AttributeError(f"module 'tamp' has no attribute {name!r}", name=name, obj=sys.modules[__name__])
        return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
