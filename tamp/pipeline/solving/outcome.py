"""What a run has come to: its status, in words and as a record."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, cast

from tamp import clock
from tamp.pipeline.plan import in_all
from tamp.pipeline.solving.job import Job
from tamp.pipeline.solving.run import Run
from tamp.results import Result, Status
from tamp.scoring import Score, score
from tamp.scoring.ede import ede, mean_edge
from tamp.task import At
from tamp.task.files.plan_file import plan_sha256
from tamp.versions import versions

USED_UP = 0.9  # of the limit are used up where the last search ended for want of time


def closed(job: Job, execute: bool) -> Run:
    """What a run has come to; with `execute` its score counts, or else its plan."""
    reached = score(job.task, job.final_poses, job.facts)
    status = _status(job, execute, reached)
    perception = _perception(job, reached)
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
        message="" if status in ("solved", "planned") else _message(job, reached, status, perception),
        remarks=job.remarks,
        versions=versions(),
        task_path="" if job.task.path is None else str(job.task.path),
        level=job.task.level,
        clock=job.settings.clock,
        domain=job.settings.domain or job.task.domain,
        strategy=job.strategy,
        simulator=job.settings.chosen("simulator"),
        **perception,
        settings=job.settings.recorded() | {"timeout_s": job.limit, "execute": execute},
    )
    executions, rejections = tuple(job.executions), tuple(job.rejections)
    looks = () if job.perceived is None else job.perceived.looks
    reports = tuple(job.reports)
    plans = tuple(job.plans)
    return Run(result, plans, executions, job.final_poses, job.failure, rejections, job.words, looks, reports)


def _status(job: Job, execute: bool, reached: Score) -> Status:
    if job.plans and not execute:
        return "failed" if job.left else "planned"
    if job.executions and reached.solved:
        return "solved"
    if job.executions or job.failure is None:
        return "failed"
    used_up = job.planning_s >= USED_UP * job.limit
    return cast("Status", in_all(job.failure.status, used_up=used_up))


def _message(job: Job, reached: Score, status: Status, perception: Mapping[str, Any]) -> str:
    missed = [name for name, met in reached.goals_met.items() if not met]
    parts = [f"goals not reached: {', '.join(missed)}"] if missed and job.executions else []
    if job.executions and job.executions[-1].deviation is not None:
        parts.append(f"last deviation: {job.executions[-1].deviation}")
    if job.executions and job.executions[-1].status == "timeout":
        parts.append(f"execution passed its limit of {job.task.limits.execution_sim_s:g} simulated seconds")
    parts += [f"{name} left: {why}" for name, why in job.left.items()]
    parts += _beyond_reach(job, [name for name in missed if name not in job.left])
    unseen = job.perceived.unseen if job.perceived else ()
    fates = {o["name"]: o["fate"] for o in perception.get("perception", ()) if job.executions}
    parts += [f"{name}: {fates[name]}" for name in missed if name in fates and name not in (*job.left, *unseen)]
    parts += [f"{name} was not seen" for name in unseen]
    if job.failure is not None and not job.left:
        parts += [f"no plan ({status})", *job.obstacles]
        if isinstance(job.failure.report, clock.TimeUp):
            parts.append(str(job.failure.report))
    return "; ".join(parts)


def _beyond_reach(job: Job, missed: Iterable[str]) -> Iterator[str]:
    """Yield a sentence for each object that is where its goal settles, which is too far from where the task has it."""
    for name in missed:
        if name not in job.resting or name not in job.final_poses:  # a fact, or nobody knows where
            continue
        thing, end = job.task.object(name), job.final_poses[name]
        edge = mean_edge(thing.shape)
        if isinstance(thing.goal, At) and ede(edge, end, job.resting[name]) <= job.settings.tuning.astray_m:
            off = 100 * ede(edge, end, thing.goal.pose)
            yield f"{name} is where its goal comes to rest, {off:.1f} cm (EDE) from the pose that is asked for"


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
