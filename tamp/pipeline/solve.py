"""The whole job of one task: planned, executed, planned again where reality deviates, scored, written up."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from typing_extensions import Unpack

from tamp import clock
from tamp.clock import FOREVER_S, TimeUp, ended_at, limits_in
from tamp.errors import PlanningFailure
from tamp.execution.executor import Executor, open_execution
from tamp.execution.log import Execution
from tamp.pipeline.options.settings import DEFAULT_SETTINGS, Options, Settings, settings_of
from tamp.pipeline.options.trust import refuse_code
from tamp.pipeline.plan import Planning, in_all
from tamp.pipeline.prepare import Setup, load_samplers, prepare
from tamp.pipeline.repair import Resuming
from tamp.pipeline.risk import worth_its_risk
from tamp.pipeline.run import Run
from tamp.pipeline.situation import SAME_PLACE
from tamp.results import Result, Status
from tamp.scoring import Score, score
from tamp.scoring.ede import ede, mean_edge
from tamp.task import Grip, Move, Plan, Pose, SymbolicFact, Task, task_robot
from tamp.task.files.plan_file import plan_sha256
from tamp.threads import one_thread
from tamp.versions import versions

if TYPE_CHECKING:
    from tamp.pipeline.perceived.run import Perceived

USED_UP = 0.9  # of the limit are used up where the last search ended for want of time
BRIEF = 5.0  # a second search in less than this would find nothing, and be late [s]
ANOTHER_SEED = 7919  # the seeds of one run's searches differ by this


@dataclass
class Job:
    """A run in the making."""

    task: Task
    seed: int
    limit: float
    settings: Settings
    began: float = field(default_factory=time.monotonic)
    planning_s: float = 0.0
    searches: int = 0
    plans: list[Plan] = field(default_factory=list)
    executions: list[Execution] = field(default_factory=list)
    final_poses: dict[str, Pose] = field(default_factory=dict)
    facts: tuple[SymbolicFact, ...] = ()
    failure: PlanningFailure | None = None
    hurried: bool = False
    obstacles: list[str] = field(default_factory=list)
    rejections: list[str] = field(default_factory=list)
    hopeless: dict[str, tuple[Pose, str]] = field(default_factory=dict)
    amended: set[str] = field(default_factory=set)
    strategy: str = ""
    words: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    perceived: Perceived | None = None

    @contextmanager
    def planning(self) -> Iterator[None]:
        """Counts what happens inside as planning, and ends it with the limit.

        Raises:
            PlanningFailure: where it had to be interrupted.
        """
        began = clock.now()
        try:
            with ended_at(began + self.limit - self.planning_s):
                yield
        except TimeUp as late:
            raise PlanningFailure("timeout", late) from None
        finally:
            self.planning_s += clock.now() - began

    def plan(self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...]) -> bool:
        """Plan from a state at rest; False where there is no plan."""
        tuning = self.settings.tuning
        share = (
            (tuning.last_plan_share if self.unfinished else tuning.next_plan_share)
            if self.plans
            else tuning.first_plan_share
        )
        if (1 - share) * (tuning.punctual_share * self.limit - self.planning_s) < BRIEF:
            share = 1.0  # what would be kept serves nobody
        try:
            search, found = self._search(setup, poses, q, share)
            # What was kept for later plans serves for this one, where it is enough to begin anew.
            if (
                found is None
                and search.cut_short
                and self.settings.tuning.punctual_share * self.limit - self.planning_s > BRIEF
            ):
                self.rejections += search.rejections
                search, found = self._search(setup, poses, q, 1.0)
        except PlanningFailure as failure:  # no time was left to begin, or it had to be interrupted
            self.failure = failure
            return False
        self.rejections += search.rejections
        if found is None:
            self.failure = PlanningFailure(search.report.status, search.report)
            self.obstacles = [f"{name}: {why}" for name, why in search.left.items()]
            return False
        self.plans.append(found)
        self.hurried = search.cut_short
        return True

    def insist(self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...]) -> bool:
        """Plan again after a search in vain, while time is left: other seeds find other plans.

        Returns:
            Whether a plan was found that moves anything and is worth its risk.
        """
        for _ in range(self.settings.tuning.max_vain_plans):
            proven = self.failure is not None and self.failure.status == "infeasible"
            if proven or self.settings.tuning.punctual_share * self.limit - self.planning_s < BRIEF:
                return False
            self.hopeless.clear()
            before = len(self.plans)
            if self.plan(setup, poses, q):
                if self.worthwhile(setup):
                    return True
                del self.plans[max(1, before) :]  # nothing to carry out, and nothing new to say
        return False

    def worthwhile(self, setup: Setup) -> bool:
        """Whether there is something in the last plan to carry out, and it is worth its risk."""
        plan = self.plans[-1]
        failing = self.settings.tuning.failing_share
        return bool(plan.actions) and worth_its_risk(self.task, setup.world.robot, plan, failing, self.chance)

    def _search(
        self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...], share: float
    ) -> tuple[Planning, Plan | None]:
        """Search for a plan in a share of the time that is left."""
        self.searches += 1
        with self.planning():
            search = Planning(
                setup,
                poses,
                q,
                # A new search, from a state that chance has brought about or after one in vain, draws other samples.
                seed=self.seed + ANOTHER_SEED * (self.searches - 1),
                deadline=clock.now() + share * (self.settings.tuning.punctual_share * self.limit - self.planning_s),
                settings=self.settings,
                facts=self.facts,
                hopeless={name: why for name, (pose, why) in self.hopeless.items() if self._is_at(name, pose, poses)},
            )
            found = search.run()
            self.hopeless |= search.hopeless
            return search, found

    def _is_at(self, name: str, pose: Pose, poses: Mapping[str, Pose]) -> bool:
        return ede(mean_edge(self.task.object(name).shape), pose, poses[name]) < SAME_PLACE

    def keep(self, setup: Setup, execution: Execution) -> bool:
        """Go on with what is still good of the last plan after an execution that stopped; False where nothing is."""
        try:
            with self.planning():
                left = self.settings.tuning.punctual_share * self.limit - self.planning_s
                seed, deadline = self.seed + ANOTHER_SEED * self.searches, clock.now() + left
                resuming = Resuming(setup, self.settings, seed, deadline, self.chance, self.facts)
                rest, amended = resuming.resume(self.plans[-1], execution, self.amended)
        except PlanningFailure as failure:
            self.failure = failure
            return False
        self.amended |= amended
        if rest is not None:
            self.plans.append(rest)
        return rest is not None

    @property
    def chance(self) -> float:
        """That what goes wrong is planned for anew: the more time there is, the surer."""
        return max(0.0, self.settings.tuning.punctual_share - self.planning_s / self.limit)

    @property
    def unfinished(self) -> bool:
        """Whether the last search ran out of time for anything, so that more may bring what its plan leaves."""
        return self.hurried and bool(self.left)

    @property
    def missed(self) -> set[str]:
        """Objects that the last plan was to bring to their goals and that are not there."""
        goals_met = score(self.task, self.final_poses, self.facts).goals_met
        return {name for name, met in goals_met.items() if not met} - self.left.keys()

    def astray(self, setup: Setup) -> set[str]:
        """Those, and the objects that are there only nearly, as far as the last plan could bring them."""
        goals = {name: place.pose for name, place in setup.goals.items()}
        nearly = {
            name
            for name, goal in (goals | dict(self.plans[-1].goals if self.plans else {})).items()
            if ede(mean_edge(self.task.object(name).shape), self.final_poses[name], goal)
            > self.settings.tuning.astray_m
        }
        return (self.missed | nearly) - self.left.keys()

    @property
    def left(self) -> Mapping[str, str]:
        """Objects whose goals the last plan leaves, and why."""
        left: Mapping[str, str] = self.plans[-1].report.get("left", {}) if self.plans else {}
        return left


def closed(job: Job, execute: bool) -> Run:
    """What a run has come to; with `execute` its score counts, or else its plan."""
    reached = score(job.task, job.final_poses, job.facts)
    status = _status(job, execute, reached)
    result = Result(
        task=job.task.name,
        seed=job.seed,
        status=status,
        planning_s=job.planning_s,
        execution_sim_s=sum(e.sim_s for e in job.executions) if job.perceived is None else job.perceived.sim_s,
        wall_s=time.monotonic() - job.began,
        n_actions=sum(len(e.log) for e in job.executions) or sum(len(p.actions) for p in job.plans[:1]),
        n_replans=max(0, len(job.plans) - 1),
        grasps_attempted=sum(e.grasps_attempted for e in job.executions),
        grasps_succeeded=sum(e.grasps_succeeded for e in job.executions),
        # Planning hands out nothing that the checker has not accepted, but for goals that are left.
        plan_checked=bool(job.plans) and not any(plan.report.get("left") for plan in job.plans),
        plans_rejected=len(job.rejections),
        do_nothing_ede_m=reached.do_nothing_ede_m,
        mean_ueb_m=reached.mean_ueb_m,
        **(_outcome(reached) if execute else {}),  # what was not executed has no score
        plan_sha256=plan_sha256(job.plans[0]) if job.plans else "",
        message="" if status in ("solved", "planned") else _message(job, reached, status),
        remarks=job.remarks,
        versions=versions(),
        task_path="" if job.task.path is None else str(job.task.path),
        level=job.task.level,
        clock=job.settings.clock,
        domain=job.settings.domain or job.task.domain,
        strategy=job.strategy,
        simulator=job.settings.chosen("simulator"),
        **_perception(job, reached),
        settings=job.settings.recorded() | {"timeout_s": job.limit, "execute": execute},
    )
    executions, rejections = tuple(job.executions), tuple(job.rejections)
    looks = () if job.perceived is None else job.perceived.looks
    return Run(result, tuple(job.plans), executions, job.final_poses, job.failure, rejections, job.words, looks)


def _status(job: Job, execute: bool, reached: Score) -> Status:
    if job.plans and not execute:
        return "failed" if job.left else "planned"
    if job.executions and reached.solved:
        return "solved"
    if job.executions or job.failure is None:
        return "failed"
    used_up = job.planning_s >= USED_UP * job.limit
    return cast("Status", in_all(job.failure.status, used_up=used_up))


def _message(job: Job, reached: Score, status: Status) -> str:
    missed = [name for name, met in reached.goals_met.items() if not met]
    parts = [f"goals not reached: {', '.join(missed)}"] if missed and job.executions else []
    if job.executions and job.executions[-1].deviation is not None:
        parts.append(f"last deviation: {job.executions[-1].deviation}")
    if job.executions and job.executions[-1].status == "timeout":
        parts.append(f"execution passed its limit of {job.task.limits.execution_sim_s:g} simulated seconds")
    parts += [f"{name} left: {why}" for name, why in job.left.items()]
    parts += [f"{name} was not seen" for name in (job.perceived.unseen if job.perceived else ())]
    if job.failure is not None and not job.left:
        parts += [f"no plan ({status})", *job.obstacles]
        if isinstance(job.failure.report, clock.TimeUp):
            parts.append(str(job.failure.report))
    return "; ".join(parts)


def _outcome(reached: Score) -> dict[str, Any]:
    return {
        "ede_m": reached.ede_m,
        "improvement": reached.improvement,
        "improvement_ueb": reached.improvement_ueb,
        "objects": tuple(vars(o) for o in reached.objects),
        "goals_met": reached.goals_met,
    }


def _perception(job: Job, reached: Score) -> dict[str, Any]:
    if job.perceived is None:
        return {"perceived": job.settings.perceive is not None}
    told = job.perceived.outcomes(job.plans, job.executions, reached)
    return {"perceived": True, "perceiving_s": job.perceived.perceiving_s, "perception": told}


__all__ = ["Run", "carry_out", "solve"]


def solve(
    task: Task, *, seed: int = 0, timeout: float | None = None, execute: bool = True, **options: Unpack[Options]
) -> Result:
    """Do the whole job and say how it went: see `carry_out`; options are the fields of its settings."""
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
        TaskError, RobotError, SamplerError: where the input cannot be used.
    """
    refuse_code(task, settings.domain, trusted=settings.trust_task_code)
    limit = min(FOREVER_S, task.limits.planning_s if timeout is None else timeout)
    load_samplers(task, settings)
    job = Job(task, seed, limit, settings)
    with limits_in(settings.clock), one_thread():
        return _carried_out(job, execute)


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
            job.hopeless.clear()
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
