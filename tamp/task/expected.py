"""What is no task, or no plan, is refused in one sentence by whatever takes one; for Python, which checks no types."""

from __future__ import annotations

from tamp.errors import PlanError, TaskError
from tamp.task.model import Task
from tamp.task.plan import Plan


def expect_task(task: object) -> None:
    """Refuse what is no task.

    Raises:
        TaskError: says what it is, and what would be valid.
    """
    if not isinstance(task, Task):
        raise TaskError(f"expected a Task, such as tamp.load_task reads from a file, found {_told(task)}")


def expect_both(task: object, plan: object) -> None:
    """Refuse what is no task, what is no plan, and both in the wrong order.

    Raises:
        TaskError, PlanError: says what it is, and what would be valid.
    """
    if isinstance(task, Plan) and isinstance(plan, Task):
        raise TaskError("task and plan are swapped: the task comes first, then the plan")
    expect_task(task)
    if not isinstance(plan, Plan):
        raise PlanError(f"expected a Plan, such as tamp.load_plan reads from a file, found {_told(plan)}")


def _told(value: object) -> str:
    return f"{value!r:.60}" if isinstance(value, str | None) else f"a {type(value).__name__}"
