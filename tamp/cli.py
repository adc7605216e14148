"""The `tamp` command: parse, call, print. What a command does is imported only when it runs."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from tamp.errors import TampError

SOLVED, UNSOLVED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

Add = Callable[..., argparse.Action]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit status: 0 all solved, 1 some not solved, 2 bad input or usage, 130 interrupted."""
    options = _parser().parse_args(arguments)
    # Samplers of the user's own are found where the user stands, as with `python -m`.
    if "" not in sys.path and str(Path.cwd()) not in sys.path:
        sys.path.insert(0, str(Path.cwd()))
    module, _, function = options.run.partition(":")
    try:
        status: int = getattr(importlib.import_module(f"tamp.commands.{module}"), function)(options)
        sys.stdout.flush()
    except TampError as error:
        print(f"tamp: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("tamp: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # whoever read our output has gone; Python would complain again when flushing at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return UNSOLVED
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="tamp", description="Task and motion planning at a cluttered table.")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _add_solve(commands)
    _add_steps(commands)
    _add_rest(commands)
    return parser


def _add_solve(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    solve = commands.add_parser("solve", help="plan, check, execute and score tasks", description="Solve tasks.")
    add = solve.add_argument
    add("tasks", nargs="*", type=Path, metavar="TASK.yaml")
    add("--seed", type=_natural, action="append", metavar="N", help="repeat it for several seeds; default 0")
    _add_planning_options(add)
    add("--workers", type=_positive_int, default=1, metavar="N", help="tasks at the same time; default 1")
    add("--no-execute", action="store_true", help="only plan and check")
    add("--output", type=Path, metavar="DIR", help="results.jsonl and one folder per run")
    add("--json", type=Path, metavar="FILE", help="the results as one JSON array")
    add("--resume", action="store_true", help="run only what results.jsonl in --output does not have yet")
    add("--replay", type=Path, metavar="RUN", help="run again what a run's folder records, and compare the plans")
    add("--time-limit", type=_seconds, metavar="SECONDS", help="kill a task that takes longer in all; default: ample")
    add("--memory-limit", type=_seconds, default=6.0, metavar="GIB", help="kill a task that takes more; default 6")
    solve.set_defaults(run="solve:solve")


def _add_steps(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    plan = _command(commands, "plan", "steps:plan", "plan a task and write the plan", "task")
    plan.add_argument("-o", "--output", type=Path, metavar="PLAN.json", help="where the plan goes")
    plan.add_argument("--seed", type=_natural, default=0, metavar="N")
    _add_planning_options(plan.add_argument)
    check = _command(commands, "check", "steps:check", "judge a plan independently of the planner", "task", "plan")
    _add_outside(check.add_argument)
    execute = _command(commands, "execute", "steps:execute", "carry a plan out in the simulator", "task", "plan")
    execute.add_argument("-o", "--output", type=Path, metavar="POSES.json", help="where the final poses go")
    execute.add_argument("--seed", type=_natural, default=0, metavar="N")
    _add_outside(execute.add_argument)
    score = _command(commands, "score", "steps:score", "score final poses from any source", "task", "poses")
    score.add_argument("--json", type=Path, metavar="FILE", help="the score as a JSON object")
    _add_outside(score.add_argument)


def _add_rest(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    source = commands.add_parser("import", help="turn other task files into task.yaml files")
    source.add_argument("format", choices=("ocrtoc",))
    source.add_argument("folder", type=Path, metavar="FOLDER")
    source.add_argument("-o", "--output", type=Path, metavar="OUT", required=True)
    source.set_defaults(run="formats:import_tasks")
    for name, run, text in (
        ("robots", "listing:robots", "list the installed robots"),
        ("domains", "listing:domains", "list the installed domains and their streams"),
        ("samplers", "listing:samplers", "list the streams and the samplers that serve them"),
        ("doctor", "doctor:doctor", "show versions and binaries, and test the installation"),
    ):
        commands.add_parser(name, help=text, description=text).set_defaults(run=run)


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], name: str, run: str, text: str, *files: str
) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=text, description=text)
    for file in files:
        command.add_argument(file, type=Path, metavar="TASK.yaml" if file == "task" else f"{file.upper()}.json")
    command.set_defaults(run=run)
    return command


def _add_planning_options(add: Add) -> None:
    add("--timeout", type=_seconds, metavar="SECONDS", help="for all planning of a task; default: the task's own limit")
    add("--algorithm", choices=("adaptive", "focused", "incremental"), default="adaptive")
    add("--sampler", type=_replacement, action="append", default=[], metavar="NAME=MODULE:FUNCTION")
    _add_outside(add)


def _add_outside(add: Add) -> None:
    add("--allow-outside", action="store_true", help="accept meshes outside the task's folder")


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def _natural(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text} is not a number 0, 1, 2, ...")
    return int(text)


def _positive_int(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text} is not a number 1, 2, 3, ...")
    return int(text)


def _replacement(text: str) -> tuple[str, str]:
    stream, equals, address = text.partition("=")
    if not stream or not equals or ":" not in address:
        raise argparse.ArgumentTypeError(f"{text} is not of the form NAME=MODULE:FUNCTION")
    return stream, address


if __name__ == "__main__":
    sys.exit(main())
