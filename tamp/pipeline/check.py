"""The checker as users call it: by the rules of the domain that the task names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from tamp.checking import Tolerances, Verdict
from tamp.checking import check as judge
from tamp.domains.catalog import load_domain
from tamp.pipeline.options.trust import refuse_code
from tamp.task import Plan, Pose, SymbolicFact, Task
from tamp.task.expected import expect_both


def check(
    task: Task,
    plan: Plan,
    *,
    start: Mapping[str, Pose] | None = None,
    goals: Mapping[str, Pose] | None = None,
    facts: Iterable[SymbolicFact] | None = None,
    domain: str | None = None,
    trust_task_code: bool = False,
    allow: Tolerances | None = None,
) -> Verdict:
    """Judge a plan from the task and the plan alone; see `tamp.checking.check.check`.

    Args:
        task: what is to be done.
        plan: how.
        start: where the objects are known to stand (world frame); without it, where the task says, settled.
        goals: the poses that goals are known to settle to (world frame); without it, where the task says, settled.
        facts: the symbolic facts that are known to hold at the start; without it those that the task names.
        domain: whose rules hold, in place of the task's own.
        trust_task_code: import the domain that the task's file names where it is not an installed one.
        allow: tolerances in place of the checker's.

    Raises:
        PlanError: where the plan is for another task or robot.
        DomainError, TaskError, RobotError: where domain, meshes or robot cannot be used.
    """
    expect_both(task, plan)
    refuse_code(replace(task, samplers={}), domain, trusted=trust_task_code)
    rules = load_domain(domain or task.domain).rules
    return judge(
        task, plan, start=start, goals=goals, facts=facts, rules=rules, allow=Tolerances() if allow is None else allow
    )
