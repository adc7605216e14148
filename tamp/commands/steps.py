"""`tamp plan`, `check`, `execute`: the steps of solving one at a time, through files."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tamp.cli import SOLVED, UNSOLVED
from tamp.commands.output import to_stdout, write_json
from tamp.errors import PlanningFailure
from tamp.task.load import load_task
from tamp.task.plan_file import load_plan, plan_sha256, save_plan

if TYPE_CHECKING:
    from tamp.execution.record import Execution


def plan(options: argparse.Namespace) -> int:
    """Plan a task, print the actions, write the plan."""
    from tamp.pipeline.planning import plan as plan_task

    task = load_task(options.task, allow_outside=options.allow_outside)
    try:
        found = plan_task(
            task,
            seed=options.seed,
            timeout=options.timeout or task.limits.planning_s,
            samplers=dict(options.sampler),
            algorithm=options.algorithm,
        )
    except PlanningFailure as failure:
        print(failure, file=sys.stderr)
        write_json(options.json, {"status": failure.status, "message": str(failure.report), "actions": []})
        return UNSOLVED
    digest = plan_sha256(found)
    if not to_stdout(options.json):
        for number, action in enumerate(found.actions):
            print(f"{number:3d}  {action}")
        print(f"{len(found.actions)} actions, {found.duration:.1f} s of motion, {digest[:12]}")
    told = {"duration_s": found.duration, "plan_sha256": digest, "report": dict(found.report)}
    write_json(options.json, {"status": "planned", "actions": [str(action) for action in found.actions], **told})
    if options.output is not None:
        save_plan(found, options.output)
    return SOLVED


def check(options: argparse.Namespace) -> int:
    """Print the checker's verdict."""
    from tamp.checking import check as check_plan

    task = load_task(options.task, allow_outside=options.allow_outside)
    verdict = check_plan(task, load_plan(options.plan))
    if not to_stdout(options.json):
        print(verdict)
    write_json(options.json, {"accepted": verdict.accepted, "problems": [asdict(p) for p in verdict.problems]})
    return SOLVED if verdict.accepted else UNSOLVED


def execute(options: argparse.Namespace) -> int:
    """Carry a plan out, print what happened, write the final poses."""
    from tamp.execution.executor import execute as execute_plan
    from tamp.pipeline.records import save_poses

    task = load_task(options.task, allow_outside=options.allow_outside)
    run = execute_plan(task, load_plan(options.plan), seed=options.seed)
    if not to_stdout(options.json):
        for entry in run.log:
            print(f"{entry.sim_s:7.1f} s  {entry.name}{''.join(f'; {d}' for d in entry.deviations)}")
        print(f"{run.status} after {run.sim_s:.1f} s; grasps {run.grasps_succeeded}/{run.grasps_attempted}")
    write_json(options.json, _told(run))
    if options.output is not None:
        save_poses(run.final_poses, options.output)
    return SOLVED if run.status == "done" else UNSOLVED


def _told(run: Execution) -> dict[str, Any]:
    return {
        "status": run.status,
        "sim_s": run.sim_s,
        "grasps_attempted": run.grasps_attempted,
        "grasps_succeeded": run.grasps_succeeded,
        "actions": [{"name": e.name, "sim_s": e.sim_s, "deviations": [str(d) for d in e.deviations]} for e in run.log],
        "final_poses": {name: {"xyz": list(p.xyz), "quat": list(p.quat)} for name, p in run.final_poses.items()},
    }
