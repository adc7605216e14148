"""`tamp contest`: other people's solutions, run in isolation and scored; the web service; its teams."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.cli.options import add_json, command, positive_int, seconds
from tamp.cli.output import to_stdout, write_json, write_text
from tamp.cli.status import SOLVED
from tamp.errors import TampError

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.cli.parser import Parser
    from tamp.contest.rules import Rules
    from tamp.task import Task


def add(commands: Commands) -> None:
    """`contest` and what it does."""
    text = "run other people's solutions against a standard API, in isolation"
    parser = commands.add_parser("contest", help=text, description=f"{text[:1].upper()}{text[1:]}.")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    _add_run(command(actions, "run", run, "run a solution on tasks and score it"))


def _add_run(parser: Parser) -> None:
    add = parser.add_argument
    add("solution", metavar="SOLUTION", help="a .py, a folder, a .zip, a .whl, or a sample: nothing, scripted, planner")
    add("--tasks", nargs="+", type=Path, metavar="TASK.yaml", help="default: the trial tasks of the rules")
    add("--rules", type=Path, metavar="contest.yaml", help="default: the paper's")
    add("--simulator", nargs="+", metavar="NAME", help="in place of the rules' simulators")
    add("--runs", type=positive_int, metavar="N", help="on each task and simulator, in place of the rules'")
    add("--wall", type=seconds, metavar="SECONDS", help="real time of a run, in place of the rules'")
    add("--library", action="append", metavar="NAME", help="a distribution to offer, beside the rules'; repeat it")
    add("-o", "--output", type=Path, metavar="DIR", help="results.json, and what each run printed")
    add_json(parser)
    _add_isolation(parser)


def _add_isolation(parser: Parser) -> None:
    parser.add_argument("--sandbox", metavar="NAME", help="bubblewrap or namespaces; default: the first that works")
    text = "run solutions as ordinary processes where there is no sandbox: only what you trust"
    parser.add_argument("--no-isolation", action="store_true", help=text)


def run(options: argparse.Namespace) -> int:
    """Print a table of what counted and write all runs; exit status 0 whatever the solution did."""
    from tamp.contest.evaluation.evaluate import evaluate, solution_path, summary, table
    from tamp.contest.sandbox.choice import choose

    solution, rules = solution_path(options.solution), _rules(options)
    tasks = _tasks(options, rules)
    sandbox = choose(name=options.sandbox, insecure=options.no_isolation)
    logs: list[bytes] = []
    results = evaluate(solution, tasks, rules, sandbox, lambda trial: logs.append(trial.log))
    found = summary(solution.stem, results, tasks, rules) | {"isolation": sandbox.name}
    if options.output is not None:
        for result, log in zip(results, logs, strict=True):
            name = re.sub(r"[^A-Za-z0-9_.-]+", "-", f"{result.task}-{result.simulator}-{result.seed}")
            write_text(options.output / f"{name}.log", log.decode("utf-8", errors="replace"))
        options.json = options.json or options.output / "results.json"
    write_json(options, found)
    if not to_stdout(options):
        print("\n".join(table(results, tasks, rules)), file=options.out)
    return SOLVED


def _rules(options: argparse.Namespace) -> Rules:
    """Those of the file, changed as the command line says."""
    from tamp.contest.rules import Rules, load_rules

    rules = Rules() if options.rules is None else load_rules(options.rules)
    if options.simulator is not None:
        rules = replace(rules, simulators=tuple(options.simulator))
    if options.runs is not None:
        rules = replace(rules, runs=options.runs)
    if options.wall is not None:
        rules = replace(rules, limits=replace(rules.limits, wall_s=options.wall))
    return replace(rules, libraries=(*rules.libraries, *(options.library or ())))


def _tasks(options: argparse.Namespace, rules: Rules) -> Sequence[Task]:
    from tamp.contest.rules import task_files
    from tamp.task.files.load import load_task

    paths = task_files(rules, "trial") if options.tasks is None else tuple(options.tasks)
    if not paths:
        raise TampError("there is no task to run on; give --tasks TASK.yaml ..., or rules with trial tasks")
    return tuple(load_task(path, allow_outside=True) for path in paths)
