"""Kinds of values on the command line, and options that several commands share."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

Commands = argparse._SubParsersAction  # the only name argparse has for it
Add = Callable[..., argparse.Action]


def command(
    commands: Commands[argparse.ArgumentParser], name: str, run: str, text: str, *files: str
) -> argparse.ArgumentParser:
    """A subcommand that takes `files`, each "task" or what a JSON file holds, and runs "module:function"."""
    parser = commands.add_parser(name, help=text, description=text)
    for file in files:
        parser.add_argument(file, type=Path, metavar="TASK.yaml" if file == "task" else f"{file.upper()}.json")
    parser.set_defaults(run=run)
    return parser


def add_planning_options(add: Add) -> None:
    """How to plan; the same for every command that does."""
    add("--timeout", type=seconds, metavar="SECONDS", help="for all planning of a task; default: the task's own limit")
    add_algorithm(add)
    add("--sampler", type=replacement, action="append", default=[], metavar="NAME=MODULE:FUNCTION")
    add_outside(add)


def add_algorithm(add: Add) -> None:
    """Which algorithm of the stream planner."""
    add("--algorithm", choices=("adaptive", "focused", "incremental"), default="adaptive")


def add_outside(add: Add) -> None:
    """Whether meshes may lie anywhere."""
    add("--allow-outside", action="store_true", help="accept meshes outside the task's folder")


def add_json(parser: argparse.ArgumentParser) -> None:
    """Where the same goes as data."""
    parser.add_argument("--json", type=Path, metavar="FILE", help="the same as JSON; - is standard output")


def add_verbosity(parser: argparse.ArgumentParser) -> None:
    """How much is said on the way."""
    parser.add_argument("-v", "--verbose", action="count", default=0, help="say what happens; -vv everything")
    parser.add_argument("-q", "--quiet", action="store_true", help="say errors only")


def seconds(text: str) -> float:
    """A positive, finite number."""
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def natural(text: str) -> int:
    """A number 0, 1, 2, ..."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text} is not a number 0, 1, 2, ...")
    return int(text)


def positive_int(text: str) -> int:
    """A number 1, 2, 3, ..."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text} is not a number 1, 2, 3, ...")
    return int(text)


def replacement(text: str) -> tuple[str, str]:
    """A stream and the address of the function that shall serve it."""
    stream, equals, address = text.partition("=")
    if not stream or not equals or ":" not in address:
        raise argparse.ArgumentTypeError(f"{text} is not of the form NAME=MODULE:FUNCTION")
    return stream, address


def setting(text: str) -> tuple[str, str]:
    """A name and its value."""
    name, equals, value = text.partition("=")
    if not name.isidentifier() or not equals:
        raise argparse.ArgumentTypeError(f"{text} is not of the form NAME=VALUE")
    return name, value
