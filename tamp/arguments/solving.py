"""Arguments of `tamp solve` and of its steps one at a time."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import (
    Commands,
    add_json,
    add_outside,
    add_planning_options,
    command,
    natural,
    positive_int,
    seconds,
    setting,
)


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`solve`, `plan`, `check`, `execute`."""
    _add_solve(commands)
    plan = command(commands, "plan", "steps:plan", "plan a task and write the plan", "task")
    plan.add_argument("-o", "--output", type=Path, metavar="PLAN.json", help="where the plan goes")
    plan.add_argument("--seed", type=natural, default=0, metavar="N")
    add_planning_options(plan.add_argument)
    add_json(plan)
    check = command(commands, "check", "steps:check", "judge a plan independently of the planner", "task", "plan")
    add_outside(check.add_argument)
    add_json(check)
    execute = command(commands, "execute", "steps:execute", "carry a plan out in the simulator", "task", "plan")
    execute.add_argument("-o", "--output", type=Path, metavar="POSES.json", help="where the final poses go")
    execute.add_argument("--seed", type=natural, default=0, metavar="N")
    add_outside(execute.add_argument)
    add_json(execute)


def _add_solve(commands: Commands[argparse.ArgumentParser]) -> None:
    solve = commands.add_parser("solve", help="plan, check, execute and score tasks", description="Solve tasks.")
    add = solve.add_argument
    add("tasks", nargs="*", type=Path, metavar="TASK.yaml")
    add("--seed", type=natural, action="append", metavar="N", help="repeat it for several seeds; default 0")
    add_planning_options(add)
    add("--no-execute", action="store_true", help="only plan and check")
    add("--output", type=Path, metavar="DIR", help="results.jsonl and one folder per run")
    add("--json", type=Path, metavar="FILE", help="the results as one JSON array; - is standard output")
    add("--csv", type=Path, metavar="FILE", help="the results as a table of comma-separated values")
    add("--replay", type=Path, metavar="RUN", help="run again what a run's folder records, and compare the plans")
    add_batch_options(solve)
    solve.set_defaults(run="solve:solve")


def add_batch_options(parser: argparse.ArgumentParser) -> None:
    """How a batch is run; the same for every command that runs one."""
    add = parser.add_argument
    add("--workers", type=positive_int, default=1, metavar="N", help="tasks at the same time; default 1")
    where = "where the work is done: here, on a Dask cluster, or as SLURM jobs; default local"
    add("--executor", choices=("local", "dask", "submitit"), default="local", help=where)
    add("--address", metavar="tcp://HOST:PORT", help="of a Dask scheduler; default: a cluster started here")
    add("--slurm", type=setting, action="append", default=[], metavar="NAME=VALUE", help="such as partition=cpu")
    add("--resume", action="store_true", help="run only what results.jsonl in --output does not have yet")
    add("--time-limit", type=seconds, metavar="SECONDS", help="kill a task that takes longer in all; default: ample")
    add("--memory-limit", type=seconds, default=6.0, metavar="GIB", help="kill a task that takes more; default 6")
