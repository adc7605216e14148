"""Carrying out a plan that the checker accepts; another one is refused before anything moves."""

from __future__ import annotations

import warnings

from tamp.errors import PlanRefusedError
from tamp.execution import executor
from tamp.execution.log import Execution
from tamp.execution.monitor import Monitor
from tamp.execution.simulators import DEFAULT
from tamp.pipeline.check import check
from tamp.task import Plan, Task
from tamp.task.expected import expect_both


def execute(
    task: Task,
    plan: Plan,
    *,
    seed: int = 0,
    jitter: float = 0.0,
    monitor: Monitor | None = executor.WATCHFUL,
    frame_s: float | None = None,
    simulator: str = DEFAULT,
    domain: str | None = None,
    trust_task_code: bool = False,
    unchecked: bool = False,
) -> Execution:
    """Check a plan, and carry it out from its own start in a simulated world.

    Args:
        task: objects, table and robot.
        plan: what is to be done.
        seed: decides the jitter.
        jitter: standard deviation of a random shift of each object on the table [m], unknown to the plan.
        monitor: when to give up the plan; None never does.
        frame_s: simulated time between recorded frames [s]; None records none.
        simulator: in which it is carried out: its name, or "package.module:Class".
        domain: by whose rules it is checked, in place of the task's own.
        trust_task_code: import the domain that the task's file names where it is not an installed one.
        unchecked: carry out what the checker rejects too, with a warning; for experiments in simulation only.

    Raises:
        PlanRefusedError: where the checker rejects the plan; nothing has moved.
        PlanError: where the plan is for another task or robot.
        TaskError, RobotError: where a mesh or the robot cannot be used.
        PartError: where a simulator of one's own raises or answers wrongly, or a checker's rule raises.
    """
    expect_both(task, plan)
    if unchecked:
        warnings.warn("carrying out a plan that was not checked", stacklevel=2)
    elif not (verdict := check(task, plan, domain=domain, trust_task_code=trust_task_code)).accepted:
        raise PlanRefusedError(f"the plan is not carried out: {verdict}")
    return executor.execute(task, plan, seed=seed, jitter=jitter, monitor=monitor, frame_s=frame_s, simulator=simulator)
