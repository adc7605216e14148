"""The whole job on one task: plan, check, execute, watch, plan again where needed, score."""

from __future__ import annotations

from tamp.errors import PlanningFailure
from tamp.execution.executor import Executor, open_execution
from tamp.pipeline.attempt import Samplers
from tamp.pipeline.books import closed
from tamp.pipeline.job import Job
from tamp.pipeline.run import Run
from tamp.pipeline.setup import Setup, prepare
from tamp.results import Result
from tamp.task import Grip, Move, Plan, Task, load_robot

__all__ = ["Run", "carry_out", "solve"]

MAX_REPLANS = 8
MAX_CORRECTIONS = 2


def solve(
    task: Task,
    *,
    seed: int = 0,
    timeout: float | None = None,
    samplers: Samplers | None = None,
    algorithm: str = "adaptive",
    execute: bool = True,
) -> Result:
    """Do the whole job and say how it went; see `carry_out`."""
    return carry_out(task, seed=seed, timeout=timeout, samplers=samplers, algorithm=algorithm, execute=execute).result


def carry_out(
    task: Task,
    *,
    seed: int = 0,
    timeout: float | None = None,
    samplers: Samplers | None = None,
    algorithm: str = "adaptive",
    execute: bool = True,
) -> Run:
    """Settle a task, plan it, execute the plan in the simulator, replan where reality deviates, and score the end.

    Args:
        task: what is to be done.
        seed: decides every random choice.
        timeout: for all planning together [wall s]; the task's own limit where it is None.
        samplers: stream name -> function or "package.module:function".
        algorithm: of the stream planner.
        execute: whether to carry the plan out; without it the end is the start.

    Raises:
        TaskError, RobotError, SamplerError: where the input cannot be used.
    """
    limit = task.limits.planning_s if timeout is None else timeout
    job = Job(task, seed, limit, samplers, algorithm)
    try:
        with job.planning():
            setup = prepare(task, job.began + limit)
    except PlanningFailure as failure:
        job.failure, job.final_poses = failure, {thing.name: thing.pose for thing in task.objects}
        return closed(job, execute)
    home = load_robot(task.robot).home
    job.final_poses = dict(setup.start)
    if job.plan(setup, setup.start, home) and execute:
        with open_execution(task, setup.start, home, seed=seed) as executor:
            _execute(job, setup, executor)
    return closed(job, execute)


def _execute(job: Job, setup: Setup, executor: Executor) -> None:
    """Carry out plan after plan: what is left of one or a new one where reality deviates; in the end corrections.

    What a plan has left for want of time is planned for with what time was kept for deviations that did not come.
    """
    replans, corrections, whole = 0, 0, job.plans[-1]
    while True:
        execution = executor.carry_out(job.plans[-1])
        job.executions.append(execution)
        job.final_poses = dict(execution.final_poses)
        if execution.status == "timeout":
            return
        if execution.status == "deviated" and job.keep(setup, execution):
            continue
        if replans == MAX_REPLANS:
            return
        astray, missed = job.astray(setup), job.missed
        done = execution.status == "done" and job.plans[-1].actions[-1:] == whole.actions[-1:]
        unfinished = done and job.unfinished
        if done and not unfinished:
            if not missed and (not astray or corrections == MAX_CORRECTIONS):
                return
            corrections += 1
        if not job.plan(setup, job.final_poses, execution.configuration):
            return
        replans, whole = replans + 1, job.plans[-1]
        if done and not unfinished and not missed and not _moved(job.plans[-1]) <= astray:
            job.plans.pop()  # what stands well is not risked for what stands a little off
            return
        if not job.plans[-1].actions:  # as far as planning can tell, all is where it should be
            return


def _moved(plan: Plan) -> set[str]:
    """Objects that a plan takes into the hand or pushes."""
    gripped = {step.attachment.object for step in plan.steps if isinstance(step, Grip)}
    pushed = {step.pushed.object for step in plan.steps if isinstance(step, Move) and step.pushed is not None}
    return gripped | pushed
