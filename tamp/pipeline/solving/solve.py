"""The whole job of one task: planned, executed, planned again where reality deviates, scored, written up."""

from __future__ import annotations

from typing import TYPE_CHECKING

from typing_extensions import Unpack

from tamp import clock
from tamp.clock import FOREVER_S, limits_in
from tamp.errors import PlanningFailure
from tamp.execution.executor import Executor, open_execution
from tamp.pipeline.loading import load_samplers
from tamp.pipeline.options.settings import DEFAULT_SETTINGS, Options, Settings, settings_of
from tamp.pipeline.options.trust import refuse_code
from tamp.pipeline.plan import refuse_arguments
from tamp.pipeline.prepare import Setup, prepare
from tamp.pipeline.solving.job import Job
from tamp.pipeline.solving.outcome import closed
from tamp.pipeline.solving.run import Run
from tamp.results import Result
from tamp.speculation import speculating
from tamp.task import Grip, Move, Plan, Task, task_robot
from tamp.task.expected import expect_task
from tamp.threads import one_thread

if TYPE_CHECKING:
    pass

__all__ = ["Run", "carry_out", "solve"]


def solve(
    task: Task, *, seed: int = 0, timeout: float | None = None, execute: bool = True, **options: Unpack[Options]
) -> Result:
    """Plan a task, execute the plan in the simulator, replan where reality deviates, and score the end.

    Args:
        task: what is to be done.
        seed: decides every random choice.
        timeout: for all planning together, on the clock of the options [s]; where it is None the task's own,
            `limits.planning_s`. (`tamp.plan` knows nothing of that: its own default is 60 s.)
        execute: whether to carry the plan out; without it the end is the start.
        **options: the fields of `tamp.pipeline.options.settings.Settings`: samplers, domain, strategy, clock, ...

    Returns:
        What came of it; that there is no plan is a status too: "timeout", "infeasible" or "failed".

    Raises:
        TaskError, DomainError, RobotError, SamplerError: where the input cannot be used.
        PartError: where a strategy, a skill or another part of one's own raises or answers wrongly.
        TampError: where seed, timeout or an option is not valid.
    """
    return carry_out(task, seed=seed, timeout=timeout, settings=settings_of(options), execute=execute).result


def carry_out(
    task: Task,
    *,
    seed: int = 0,
    timeout: float | None = None,
    settings: Settings = DEFAULT_SETTINGS,
    execute: bool = True,
) -> Run:
    """Settle a task, plan it, execute the plan in the simulator, replan where reality deviates, and score the end.

    Args:
        task: what is to be done.
        seed: decides every random choice.
        timeout: for all planning together, on the clock of the settings [s]; the task's own limit where it is None.
        settings: how it is planned and carried out.
        execute: whether to carry the plan out; without it the end is the start.

    Raises:
        TaskError, DomainError, RobotError, SamplerError: where the input cannot be used.
        PartError: where a strategy, a skill or another part of one's own raises or answers wrongly.
        TampError: where seed or timeout is not valid.
    """
    expect_task(task)
    refuse_arguments(seed, timeout)
    refuse_code(task, settings.domain, trusted=settings.trust_task_code)
    limit = min(FOREVER_S, task.limits.planning_s if timeout is None else timeout)
    load_samplers(task, settings)
    job = Job(task, seed, limit, settings)
    with limits_in(settings.clock), one_thread():
        return speculating(lambda: _carried_out(job, execute), settings.threads)


def _carried_out(job: Job, execute: bool) -> Run:
    task = job.task
    try:
        with job.planning():
            setup = prepare(task, clock.now() + job.limit, job.settings)
    except PlanningFailure as failure:
        job.failure, job.final_poses = failure, {thing.name: thing.pose for thing in task.objects}
        return closed(job, execute)
    job.settings = setup.settings
    job.strategy, job.facts = job.settings.strategy or setup.domain.strategy, task.init
    job.words, job.remarks = setup.domain.words, setup.remarks
    job.resting = {name: place.pose for name, place in setup.goals.items()}
    home = task_robot(task).home
    job.final_poses = dict(setup.start)
    if job.settings.perceive is not None:
        _perceive(job, setup, execute)
    elif (job.plan(setup, setup.start, home) or job.insist(setup, setup.start, home)) and execute:
        with open_execution(
            task, setup.start, home, seed=job.seed, simulator=job.settings.chosen("simulator")
        ) as executor:
            _execute(job, setup, executor)
    return closed(job, execute)


def _perceive(job: Job, setup: Setup, execute: bool) -> None:
    """Have the task done by what cameras see; the setup is the true world's, and no part of the job's planning."""
    from tamp.pipeline.perceived.run import perceive_and_rearrange

    task, job.planning_s, job.final_poses = job.task, 0.0, {}
    job.perceived = perceive_and_rearrange(job, task, setup.start, job.settings, job.seed, execute=execute)
    job.task, job.final_poses = task, dict(job.perceived.final_poses)


def _execute(job: Job, setup: Setup, executor: Executor) -> None:
    """Carry out plan after plan: what is left of one or a new one where reality deviates; in the end corrections.

    What a plan has left for want of time is planned for with what time was kept for deviations that did not come.
    """
    replans, corrections, whole = 0, 0, job.plans[-1]
    while True:
        execution = executor.carry_out(job.plans[-1])
        job.executions.append(execution)
        job.final_poses = dict(execution.final_poses)
        carried_out = job.plans[-1].actions[: len(execution.log)]
        job.facts = setup.domain.facts_after(job.facts, carried_out)
        if execution.status == "timeout":
            return
        if execution.status == "deviated" and job.keep(setup, execution):
            continue
        if replans == job.settings.tuning.max_replans:
            return
        astray, missed = job.astray(setup), job.missed
        done = execution.status == "done" and job.plans[-1].actions[-1:] == whole.actions[-1:]
        unfinished, wanting = done and job.unfinished, bool(missed or job.left)
        if done and not unfinished:
            if not wanting and (not astray or corrections == job.settings.tuning.max_corrections):
                return
            corrections += 1
            job.forget()
        scene = (setup, job.final_poses, execution.configuration)
        if not job.plan(*scene) and not (wanting and job.insist(*scene)):
            return
        if wanting and not job.worthwhile(setup):
            job.insist(*scene)
        replans, whole = replans + 1, job.plans[-1]
        if done and not unfinished and not wanting and not _moved(job.plans[-1]) <= astray:
            job.plans.pop()  # what stands well is not risked for what stands a little off
            return
        if not job.plans[-1].actions:  # as far as planning can tell, all is where it should be
            return
        if not job.worthwhile(setup):
            job.plans.pop()
            return


def _moved(plan: Plan) -> set[str]:
    """Objects that a plan takes into the hand or pushes."""
    gripped = {step.attachment.object for step in plan.steps if isinstance(step, Grip)}
    pushed = {step.pushed.object for step in plan.steps if isinstance(step, Move) and step.pushed is not None}
    return gripped | pushed
