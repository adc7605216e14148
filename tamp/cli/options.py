"""Options that several commands share, kinds of values, and what turns parsed options into what they mean."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp import plugins
from tamp.cli.parser import Parser
from tamp.cli.paths import DATA, output_file
from tamp.pipeline.options.settings import Settings

if TYPE_CHECKING:
    from tamp.task import Task

    Commands = argparse._SubParsersAction[Parser]  # the only name argparse has for it

Run = Callable[[argparse.Namespace], int]


def command(commands: Commands, name: str, run: Run, text: str, *files: str) -> Parser:
    """A subcommand that takes `files`, each "task" or what a JSON file holds, and calls `run`."""
    parser = commands.add_parser(name, help=text, description=f"{text[:1].upper()}{text[1:]}.")
    for file in files:
        parser.add_argument(file, type=Path, metavar="TASK.yaml" if file == "task" else f"{file.upper()}.json")
    add_verbosity(parser)
    parser.set_defaults(run=run)
    return parser


def add_planning_options(parser: Parser) -> None:
    """How to plan; the same for every command that does."""
    parser.add_argument("--sampler", type=replacement, action="append", default=[], metavar="NAME=MODULE:FUNCTION")
    add_settings(parser)
    add_trust(parser)


def add_settings(parser: Parser) -> None:
    """The limit for planning, and an option for each field of `Settings` that says how it reads on a command line."""
    limit = "for all planning of a task; default: the task's own limit"
    parser.add_argument("--timeout", type=seconds, metavar="SECONDS", help=limit)
    for field in fields(Settings):
        if "help" in field.metadata:
            bare, counted = field.metadata["bare"], isinstance(field.default, int)
            closed = () if field.metadata["own"] else field.metadata["choices"]
            others = f"; {', '.join(field.metadata['choices'])}, or package.module:NAME" * field.metadata["own"]
            kind: dict[str, Any] = {"nargs": "?", "const": bare, "type": name} if bare else {}
            parser.add_argument(
                f"--{field.name.replace('_', '-')}",
                choices=closed or None,
                metavar=None if closed else "N" if counted else "NAME",
                **({"type": positive_int} if counted else kind),
                help=field.metadata["help"] + others + (f"; default {field.default}" if field.default else ""),
            )
    tuning = (
        "a number that a user may change, such as carrying_speed=0.3; docs/reference/tuning.md has them, as has any "
        "wrong NAME"
    )
    parser.add_argument("--tuning", type=number, action="append", default=[], metavar="NAME=VALUE", help=tuning)


def settings_given(options: argparse.Namespace) -> dict[str, Any]:
    """The fields of `Settings` that the command line names; the others are the task's to say, or their defaults."""
    names = [field.name for field in fields(Settings) if "help" in field.metadata]
    given = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    return given | ({"tuning": dict(options.tuning)} if options.tuning else {})


def add_simulator(parser: Parser, text: str, default: str | None) -> None:
    """Which simulator, for commands that plan nothing."""
    parser.add_argument("--simulator", default=default, metavar="NAME", help=text)


def add_trust(parser: Parser) -> None:
    """How far a task's file is trusted, and who does what it asks."""
    parser.add_argument("--robot", metavar="NAME|PATH", help="in place of the task's own: a name or a robot.yaml")
    outside = "accept meshes and a robot outside the task's folder"
    parser.add_argument("--allow-outside", action="store_true", help=outside)
    text = "import and run the code that a task's file names, such as its samplers"
    parser.add_argument("--trust-task-code", action="store_true", help=text)


def load(path: Path, options: argparse.Namespace) -> Task:
    """The task of a file, read as `add_trust`'s options say."""
    from tamp.task.files.load import load_task
    from tamp.task.robots import with_robot

    return with_robot(load_task(path, allow_outside=options.allow_outside), options.robot)


def add_json(parser: Parser) -> None:
    """Where the same goes as data."""
    parser.add_argument("--json", type=output_file(DATA), metavar="FILE", help="the same as JSON; - is standard output")


def add_verbosity(parser: Parser) -> None:
    """How much is said on the way; without a default, so that it can stand before a command and after it."""
    unsaid = argparse.SUPPRESS
    parser.add_argument("-v", "--verbose", action="count", default=unsaid, help="say what happens; -vv everything")
    parser.add_argument("-q", "--quiet", action="store_true", default=unsaid, help="say errors only")


def name(text: str) -> str:
    """A name after an option that may stand alone, and so takes what comes next: no file."""
    if text.endswith((".yaml", ".yml")):
        raise argparse.ArgumentTypeError(f"{text} is a file, no name; put files before this option, or =NAME after it")
    return text


def seconds(text: str) -> float:
    """A positive, finite number."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def natural(text: str) -> int:
    """A number 0, 1, 2, ..."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text} is not a number 0, 1, 2, ...")
    return int(text)


def seeds(text: str) -> range:
    """A seed N, or all of N-M, both included."""
    first, _, last = text.partition("-")
    if not first.isdecimal() or not (last or first).isdecimal() or int(last or first) < int(first):
        raise argparse.ArgumentTypeError(f"{text} is neither a number 0, 1, 2, ... nor a range such as 0-19")
    return range(int(first), int(last or first) + 1)


def positive_int(text: str) -> int:
    """A number 1, 2, 3, ..."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text} is not a number 1, 2, 3, ...")
    return int(text)


def replacement(text: str) -> tuple[str, str]:
    """A stream and the function that shall serve it, by its address or as an installed sampler's name."""
    stream, equals, address = text.partition("=")
    if not stream or not equals or not is_sampler(address):
        raise argparse.ArgumentTypeError(f"{text} is not of the form NAME=MODULE:FUNCTION")
    return stream, address


def is_sampler(text: str) -> bool:
    """Whether a text has the form of a function's address, or is the name of an installed sampler."""
    return ":" in text or text in plugins.addresses("samplers")


def number(text: str) -> tuple[str, float | tuple[float, ...]]:
    """A name and a finite number, whole where it is written so, or several with commas between them."""
    name, value = setting(text)
    try:
        found = tuple(int(part) if part.strip("+-").isdecimal() else float(part) for part in value.split(","))
    except ValueError:
        found = (math.nan,)
    if not all(map(math.isfinite, found)):
        raise argparse.ArgumentTypeError(f"{text} is not of the form NAME=NUMBER or NAME=NUMBER,NUMBER")
    return name, found if len(found) > 1 else found[0]


def setting(text: str) -> tuple[str, str]:
    """A name and its value."""
    name, equals, value = text.partition("=")
    if not name.isidentifier() or not equals:
        raise argparse.ArgumentTypeError(f"{text} is not of the form NAME=VALUE")
    return name, value
