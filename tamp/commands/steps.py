"""`tamp plan`, `check`, `execute`: the steps of solving one at a time, through files."""

from __future__ import annotations

import argparse
import sys

from tamp.cli import SOLVED, UNSOLVED
from tamp.errors import PlanningFailure
from tamp.task.load import load_task
from tamp.task.plan_file import load_plan, plan_sha256, save_plan


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
        return UNSOLVED
    for number, action in enumerate(found.actions):
        print(f"{number:3d}  {action}")
    print(f"{len(found.actions)} actions, {found.duration:.1f} s of motion, {plan_sha256(found)[:12]}")
    if options.output is not None:
        save_plan(found, options.output)
    return SOLVED


def check(options: argparse.Namespace) -> int:
    """Print the checker's verdict."""
    from tamp.checking import check as check_plan

    task = load_task(options.task, allow_outside=options.allow_outside)
    verdict = check_plan(task, load_plan(options.plan))
    print(verdict)
    return SOLVED if verdict.accepted else UNSOLVED


def execute(options: argparse.Namespace) -> int:
    """Carry a plan out, print what happened, write the final poses."""
    from tamp.execution.executor import execute as execute_plan
    from tamp.pipeline.records import save_poses

    task = load_task(options.task, allow_outside=options.allow_outside)
    run = execute_plan(task, load_plan(options.plan), seed=options.seed)
    for entry in run.log:
        print(f"{entry.sim_s:7.1f} s  {entry.name}{''.join(f'; {d}' for d in entry.deviations)}")
    print(f"{run.status} after {run.sim_s:.1f} s; grasps {run.grasps_succeeded}/{run.grasps_attempted}")
    if options.output is not None:
        save_poses(run.final_poses, options.output)
    return SOLVED if run.status == "done" else UNSOLVED
