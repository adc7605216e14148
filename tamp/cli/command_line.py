"""The whole command line: parse, call, and turn what goes wrong into one sentence and an exit status."""

from __future__ import annotations

import argparse
import errno
import logging
import os
import signal
import sys
import threading
import traceback
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NoReturn

from tamp.cli.apart import apart
from tamp.cli.commands import contest
from tamp.cli.commands.data import dataset, formats, generate
from tamp.cli.commands.installation import doctor, installed, robots, samplers
from tamp.cli.commands.results import compare, score, show
from tamp.cli.commands.solving import perceive, solve, steps
from tamp.cli.options import add_verbosity
from tamp.cli.output import asked_only
from tamp.cli.parser import Parser
from tamp.cli.status import BAD_INPUT, INTERRUPTED, UNSOLVED
from tamp.errors import TampError

FAMILIES = (
    solve, steps, perceive, dataset, score, compare, contest, show, formats, generate, samplers, robots, installed,
    doctor,
)  # fmt: skip
"""The modules that add commands, in the order of `tamp --help`."""

CODE = {"a sampler": ("sampler", "contender", "address"), "code of the task": ("trust_task_code",)}
"""What is somebody's code where it is given: options by what they name."""
ADDRESSED = {
    "a domain": ("domain",), "a strategy": ("strategy",), "a search": ("search",),
    "a simulator": ("simulator", "settling"), "a perceiver": ("perceive", "perceiver"),
    "a controller": ("controller",),
}  # fmt: skip
"""What is so where it is given by its address, and not by the name of what is installed."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit status: 0 all solved, 1 some not solved, 2 bad input or usage, 130 interrupted."""
    return _carry_out(_parsed(arguments))


def _parsed(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    whole = parser()
    options = whole.parse_args(arguments)
    options.parser = whole
    return options


def _carry_out(options: argparse.Namespace) -> int:
    """Run the command of parsed options, and turn what goes wrong into its exit status."""
    _log(options.quiet, options.verbose)
    if _named_code(options) and "" not in sys.path and str(Path.cwd()) not in sys.path:
        sys.path.append(str(Path.cwd()))
    try:
        with asked_only() as options.out:
            status: int = options.run(options)
    except TampError as error:
        if options.verbose:
            traceback.print_exc()
        print(f"tamp: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as interrupted:
        print(": ".join(["tamp: interrupted", *map(str, interrupted.args)]), file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # whoever read our output has gone; Python would complain again when flushing at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return UNSOLVED
    except OSError as error:  # of a file: a folder that may not be written, a disk that is full; all else is a bug
        if error.filename is None and error.errno != errno.ENOSPC:
            raise
        if options.verbose:
            traceback.print_exc()
        where = "" if error.filename is None else f"{error.filename}: "
        print(f"tamp: {where}{error.strerror}", file=sys.stderr)
        return BAD_INPUT
    return status


def run() -> NoReturn:
    """The command as a process: `main`, and the end."""
    for number in (signal.SIGTERM, signal.SIGHUP):  # of a scheduler, `timeout`, or a terminal that is closed
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _interrupt)
            os.register_at_fork(after_in_child=partial(signal.signal, number, signal.SIG_DFL))
    options = _parsed()
    named = _named_code(options)
    _leave(apart(_carry_out, options, _leave, " or ".join(named)) if named else _carry_out(options))


def _interrupt(number: int, _: object) -> NoReturn:
    """End the command as Ctrl-C does: what is done is kept, and how to go on is said."""
    raise KeyboardInterrupt


def _leave(status: int) -> NoReturn:
    """End the process, whatever threads and closed streams samplers have left behind."""
    for stream in (sys.stdout, sys.stderr):
        if not stream.closed:
            stream.flush()
    if any(thread is not threading.main_thread() and not thread.daemon for thread in threading.enumerate()):
        os._exit(status)
    sys.exit(status)


def parser() -> Parser:
    """All commands with their options."""
    statuses = "exit status: 0 all solved, 1 some not solved, 2 bad input or usage, 130 interrupted"
    about = "Task and motion planning at a cluttered table."
    whole = Parser(prog="tamp", description=about, epilog=statuses)
    whole.set_defaults(verbose=0, quiet=False, line=None)
    add_verbosity(whole)
    whole.add_argument("--version", action=_Version, help="show the version and exit")
    commands = whole.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for family in FAMILIES:
        family.add(commands)
    return whole


class _Version(argparse.Action):
    """`--version`; what is installed is looked up only when somebody asks."""

    def __init__(self, option_strings: Sequence[str], dest: str, help: str) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, nargs=0, help=help)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from tamp.versions import versions

        print(f"tamp {versions()['tabletop-tamp']}")
        parser.exit()


def _named_code(options: argparse.Namespace) -> Sequence[str]:
    """What the user names that is code of somebody's, such as "a sampler".

    It is found where they stand, behind all that is installed. Nothing else is imported from there: the folder may be a
    stranger's, and hold a `yaml.py`.
    """

    def is_given(title: str, option: str) -> bool:
        value = getattr(options, option, None)
        if option == "domain":
            return _is_outside(value)
        return bool(value) if title in CODE else ":" in "".join(value or ())  # a name, or several

    return [title for title, names in {**CODE, **ADDRESSED}.items() if any(is_given(title, option) for option in names)]


def _is_outside(domain: str | None) -> bool:
    """Whether a domain is named that is no installed one: by its package, or an address."""
    if domain is None:
        return False
    from tamp.domains.catalog import domain_names

    try:
        return domain not in domain_names()
    except TampError:  # whoever uses the domains says that they cannot be listed
        return False


def _log(quiet: bool, verbose: int) -> None:
    """Say more or less on standard error: warnings; with -v what happens, with -vv everything; with -q errors only."""
    level = logging.ERROR if quiet else (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbose, 2)]
    logging.basicConfig(stream=sys.stderr, format="tamp: %(message)s", force=True)
    logging.getLogger("tamp").setLevel(level)
