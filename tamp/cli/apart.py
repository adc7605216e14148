"""A command that runs somebody's code, in a process of its own: one that ends from below has not succeeded."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from tamp.cli.status import BAD_INPUT
from tamp.parent import end_with_parent

INSIDE = ("plan", "samplers", "execute", "contest")
"""Commands that run samplers and simulators within their own process; batches have workers."""
PASSED_ON = (signal.SIGINT, signal.SIGTERM, signal.SIGQUIT, signal.SIGHUP)
NAMES_CODE = ("--sampler", "--domain", "--contender", "--trust-task-code", "--stream", "--simulator")


def runs_others_code(arguments: Sequence[str]) -> bool:
    """Whether a command of these arguments runs samplers or a simulator that somebody names, within its process."""
    return arguments[:1] != [] and arguments[0] in INSIDE and any(each.startswith(NAMES_CODE) for each in arguments)


def apart(command: Callable[[], int], leave: Callable[[int], NoReturn], simulated: bool = False) -> int:
    """Run a command in a child process, and return its exit status; that of an error where nobody said that it is done.

    Args:
        command: what to do; its exit status.
        leave: ends the child with that.
        simulated: whether it is a simulator that it runs, and no samplers.
    """
    done, said = os.pipe()
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)  # what the terminal sends is passed on once
        end_with_parent()
        status = command()
        os.write(said, b".")
        leave(status)
    for number in PASSED_ON:
        signal.signal(number, lambda number, _: os.kill(child, number))
    os.close(said)
    _, ended = os.waitpid(child, 0)
    os.set_blocking(done, False)  # a process that it left behind may still hold the other end
    status = os.waitstatus_to_exitcode(ended)
    if status < 0:
        print(f"tamp: the command was ended by {signal.Signals(-status).name}", file=sys.stderr)
        return 128 - status
    if status == 0 and not _told(done):
        print(f"tamp: a {'simulator' if simulated else 'sampler'} ended the program", file=sys.stderr)
        return BAD_INPUT
    return status


def _told(done: int) -> bool:
    try:
        return bool(os.read(done, 1))
    except BlockingIOError:
        return False
