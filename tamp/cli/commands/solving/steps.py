"""`tamp plan`, `check`, `execute`: the steps of solving one at a time, through files."""

from __future__ import annotations

import argparse
import functools
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tamp import clock
from tamp.cli.batches import BEYOND_LIMITS_S
from tamp.cli.options import (
    add_json,
    add_planning_options,
    add_simulator,
    add_trust,
    command,
    load,
    natural,
    seconds,
    settings_given,
)
from tamp.cli.output import to_stdout, write_json
from tamp.cli.paths import DATA, PLAN, output_file
from tamp.cli.status import SOLVED, UNSOLVED
from tamp.cli.watchdog import LastWords, ended_by_force
from tamp.errors import PlanningFailure, PlanRefusedError, TampError
from tamp.execution.simulators import DEFAULT

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.execution.log import Execution
    from tamp.task import Action, Plan, Task

DOMAIN = "whose rules hold, in place of the task's own: as for `tamp plan`"


def add(commands: Commands) -> None:
    """`plan`, `check`, `execute`."""
    parser = command(commands, "plan", plan, "plan a task and write the plan", "task")
    parser.add_argument("-o", "--output", type=output_file(PLAN), metavar="PLAN.json", help="where the plan goes")
    parser.add_argument("--seed", type=natural, default=0, metavar="N")
    add_planning_options(parser)
    add_json(parser)
    parser = command(commands, "check", check, "judge a plan independently of the planner", "task", "plan")
    parser.add_argument("--domain", metavar="NAME", help=DOMAIN)
    add_trust(parser)
    add_json(parser)
    parser = command(commands, "execute", execute, "carry a plan out in the simulator", "task", "plan")
    parser.add_argument("-o", "--output", type=output_file(DATA), metavar="POSES.json", help="where the final poses go")
    parser.add_argument("--seed", type=natural, default=0, metavar="N")
    add_simulator(parser, f"in which it is carried out; default {DEFAULT}", DEFAULT)
    controller = "let a robot's controller carry it out, not a simulator: dry-run, or package.module:Class"
    parser.add_argument("--domain", metavar="NAME", help=DOMAIN)
    parser.add_argument("--controller", metavar="NAME", help=controller)
    unchecked = "carry out what the checker rejects too: for experiments in simulation only"
    parser.add_argument("--unchecked", action="store_true", help=unchecked)
    limit = "end it where it takes longer in all, in real time; default: ample"
    parser.add_argument("--time-limit", type=seconds, metavar="SECONDS", help=limit)
    add_trust(parser)
    add_json(parser)


def plan(options: argparse.Namespace) -> int:
    """Plan a task, print the actions, write the plan."""
    from tamp.pipeline.plan import plan as plan_task
    from tamp.task.files.plan_file import plan_sha256, save_plan

    task = load(options.task, options)
    try:
        with ended_by_force(options, _no_plan("timeout", "planning could not be interrupted")):
            found = plan_task(
                task,
                seed=options.seed,
                timeout=options.timeout or task.limits.planning_s,
                samplers=dict(options.sampler),
                **settings_given(options),
                trust_task_code=options.trust_task_code,
            )
    except PlanningFailure as failure:
        return _no_plan(failure.status, str(failure.report)).say(options)
    digest = plan_sha256(found)
    if not to_stdout(options):
        for number, action in enumerate(found.actions):
            print(f"{number:3d}  {action}", file=options.out)
        told = f"{len(found.actions)} actions, {found.duration:.1f} s of motion, {digest[:12]}"
        print(told, file=options.out)
    more = {"duration_s": found.duration, "plan_sha256": digest, "report": dict(found.report)}
    write_json(options, {"status": "planned", "actions": [str(action) for action in found.actions], **more})
    if options.output is not None:
        save_plan(found, options.output)
        _say_where(options)
    return SOLVED


def _say_where(options: argparse.Namespace) -> None:
    if not to_stdout(options):
        print(options.output, file=options.out)


def _no_plan(status: str, why: str) -> LastWords:
    return LastWords(UNSOLVED, f"no plan ({status})\n{why}", {"status": status, "message": why, "actions": []})


def check(options: argparse.Namespace) -> int:
    """Print the checker's verdict."""
    from tamp.pipeline.check import check as check_plan
    from tamp.task.files.plan_file import load_plan

    task = load(options.task, options)
    verdict = check_plan(task, load_plan(options.plan), domain=options.domain, trust_task_code=options.trust_task_code)
    if not to_stdout(options):
        print(verdict, file=options.out)
    write_json(options, {"accepted": verdict.accepted, "problems": [asdict(p) for p in verdict.problems]})
    return SOLVED if verdict.accepted else UNSOLVED


def execute(options: argparse.Namespace) -> int:
    """Carry a plan out that the checker accepts, print what happened, write the final poses."""
    from tamp.pipeline.solving.run import save_poses
    from tamp.task.files.plan_file import load_plan

    task = load(options.task, options)
    made = load_plan(options.plan)
    if options.controller is not None:
        return _by_controller(task, made, options)
    if options.unchecked:
        print("tamp: WARNING: this plan is carried out UNCHECKED", file=sys.stderr)
    limit = options.time_limit or task.limits.execution_sim_s + BEYOND_LIMITS_S
    late = f"the plan was not carried out within {limit:g} s: simulator {options.simulator!r} did not come to an end"
    forced = ended_by_force(options, _not_carried_out("timeout", late))
    try:
        with forced, clock.ended_at(clock.now() + limit):
            run = _carried_out(task, made, options)
    except clock.TimeUp:
        return _not_carried_out("timeout", late).say(options)
    except PlanRefusedError as refused:
        words = _not_carried_out("refused", str(refused), "\n--unchecked carries it out all the same")
        return words.say(options)
    if not to_stdout(options):
        for entry in run.log:
            deviations = "".join(f"; {d}" for d in entry.deviations)
            print(f"{entry.sim_s:7.1f} s  {entry.name}{deviations}", file=options.out)
        grasps = f"grasps {run.grasps_succeeded}/{run.grasps_attempted}"
        print(f"{run.status} after {run.sim_s:.1f} s; {grasps}", file=options.out)
    write_json(options, _told(run))
    if options.output is not None:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        save_poses(run.final_poses, options.output)
        _say_where(options)
    return SOLVED if run.status == "done" else UNSOLVED


def _carried_out(task: Task, made: Plan, options: argparse.Namespace) -> Execution:
    from tamp.execution.executor import execute as execute_unchecked
    from tamp.pipeline.execute import execute as execute_plan

    how = {"seed": options.seed, "simulator": options.simulator}
    if options.unchecked:
        return execute_unchecked(task, made, **how)
    return execute_plan(task, made, domain=options.domain, trust_task_code=options.trust_task_code, **how)


def _not_carried_out(status: str, why: str, hint: str = "") -> LastWords:
    """Why a plan was not carried out, or not to its end."""
    return LastWords(UNSOLVED, f"tamp: {why}{hint}", {"status": status, "message": why})


def _by_controller(task: Task, made: Plan, options: argparse.Namespace) -> int:
    """Let a controller carry a plan out that the checker accepts, and print what it has done."""
    from tamp.execution.hardware.carry_out import carry_out
    from tamp.execution.hardware.controller import make_controller
    from tamp.pipeline.check import check as check_plan
    from tamp.task import task_robot

    if options.unchecked or options.output is not None:
        raise TampError("--unchecked and -o are for simulators; a --controller carries out what the checker accepts")
    controller = make_controller(options.controller, task_robot(task))
    verdict = check_plan(task, made, domain=options.domain, trust_task_code=options.trust_task_code)
    if not verdict.accepted:
        print(f"tamp: the plan is not carried out: {verdict}", file=sys.stderr)
        write_json(options, {"status": "refused", "message": str(verdict)})
        return UNSOLVED
    outcome = carry_out(task, made, controller, functools.partial(_tell, controller, options))
    status = "stopped" if outcome.stopped else "done"
    if not to_stdout(options):
        why = f"; {outcome.stopped}" if outcome.stopped else ""
        print(f"{status}: {outcome.done} of {len(made.actions)} actions{why}", file=options.out)
    told = {"status": status, "actions": outcome.done, "message": outcome.stopped}
    write_json(options, told if (seconds := _clock(controller)) is None else {**told, "seconds": seconds})
    return UNSOLVED if outcome.stopped else SOLVED


def _clock(controller: object) -> float | None:
    """What a controller's own clock says, as a dry run has one [s]; None where it has none."""
    return getattr(controller, "time", None)


def _tell(controller: object, options: argparse.Namespace, action: Action) -> None:
    """Print an action that a controller has done."""
    if not to_stdout(options):
        seconds = _clock(controller)
        print(action if seconds is None else f"{seconds:7.1f} s  {action}", file=options.out)


def _told(run: Execution) -> dict[str, Any]:
    return {
        "status": run.status,
        "sim_s": run.sim_s,
        "grasps_attempted": run.grasps_attempted,
        "grasps_succeeded": run.grasps_succeeded,
        "actions": [{"name": e.name, "sim_s": e.sim_s, "deviations": [str(d) for d in e.deviations]} for e in run.log],
        "final_poses": {name: {"xyz": list(p.xyz), "quat": list(p.quat)} for name, p in run.final_poses.items()},
    }
