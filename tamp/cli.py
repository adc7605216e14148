"""The `tamp` command: parse, call, print. What a command does is imported only when it runs."""

from __future__ import annotations

import argparse
import importlib
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from tamp.arguments import comparing, formats, generating, installed, scoring, showing, solving
from tamp.arguments.kinds import add_verbosity
from tamp.errors import TampError

SOLVED, UNSOLVED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

FAMILIES = (
    solving.add,
    scoring.add,
    comparing.add,
    showing.add,
    formats.add,
    generating.add,
    installed.add_samplers,
    installed.add,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit status: 0 all solved, 1 some not solved, 2 bad input or usage, 130 interrupted."""
    options = parser().parse_args(arguments)
    _log(options.quiet, options.verbose)
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


def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    statuses = "exit status: 0 all solved, 1 some not solved, 2 bad input or usage, 130 interrupted"
    about = "Task and motion planning at a cluttered table."
    whole = argparse.ArgumentParser(prog="tamp", description=about, epilog=statuses)
    commands = whole.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for family in FAMILIES:
        family(commands)
    for command in commands.choices.values():
        add_verbosity(command)
    return whole


def _log(quiet: bool, verbose: int) -> None:
    """Say more or less on standard error: warnings; with -v what happens, with -vv everything; with -q errors only."""
    level = logging.ERROR if quiet else (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbose, 2)]
    logging.basicConfig(stream=sys.stderr, format="tamp: %(message)s", force=True)
    logging.getLogger("tamp").setLevel(level)


if __name__ == "__main__":
    sys.exit(main())
