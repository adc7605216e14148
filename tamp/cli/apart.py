"""A command that runs somebody's code, in a process of its own: one that ends from below has not succeeded."""

from __future__ import annotations

import argparse
import json
import os
import select
import signal
import sys
import time
from collections.abc import Callable
from typing import NoReturn

from tamp.cli.status import BAD_INPUT
from tamp.cli.watchdog import LATE_S, LastWords
from tamp.parent import end_with_parent

PASSED_ON = (signal.SIGINT, signal.SIGTERM, signal.SIGQUIT, signal.SIGHUP)
LOOK_S = 0.05
"""How often it is seen whether the command has ended [s]."""


class Line:
    """On which a command tells the process that waits for it by when it must end, and that it has come to its end.

    Attributes:
        told: whether it has come to an end by itself.
        until: by when it must have ended, in time.monotonic() [s], or None.
        words: what it leaves then.
    """

    def __init__(self) -> None:
        self.told = False
        self.until: float | None = None
        self.words = LastWords(BAD_INPUT, "", {})
        self._heard, self._said = os.pipe()
        self._begun = b""

    def tell(self, words: LastWords, until: float | None) -> None:
        """Say by when this process must have ended, and what it leaves otherwise."""
        self._say([until, words.status, words.sentence, dict(words.data)])

    def done(self) -> None:
        """Say that this process comes to an end by itself."""
        self._say([])

    def _say(self, message: list[object]) -> None:
        try:
            os.write(self._said, json.dumps(message).encode() + b"\n")
        except OSError:  # a sampler has closed it: then nobody can be told
            return

    @property
    def is_late(self) -> bool:
        """Whether it must have ended before now."""
        return self.until is not None and time.monotonic() > self.until + LATE_S

    def only_listen(self) -> None:
        """Leave the other end to the command."""
        os.close(self._said)

    def listen(self, seconds: float) -> None:
        """Take in what is said within so many seconds."""
        if not select.select([self._heard], [], [], seconds)[0]:
            return
        if not (heard := os.read(self._heard, 1 << 16)):
            time.sleep(seconds)  # the other end is closed: it is only waited for
        *whole, self._begun = (self._begun + heard).split(b"\n")
        for message in map(json.loads, whole):
            if message:
                self.until, *words = message
                self.words = LastWords(*words)
            self.told = not message


def apart(
    command: Callable[[argparse.Namespace], int],
    options: argparse.Namespace,
    leave: Callable[[int], NoReturn],
    named: str,
) -> int:
    """Run a command in a child process, and return its exit status; that of an error where nobody said that it is done.

    Args:
        command: takes the options, and returns its exit status.
        options: of the command; their `line` is set.
        leave: ends the child with that status.
        named: what the user names whose code it runs, such as "a sampler".
    """
    line = options.line = Line()
    handlers = {number: signal.getsignal(number) for number in PASSED_ON}
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)  # what the terminal sends is passed on once
        end_with_parent()
        for number, handler in handlers.items():
            signal.signal(number, handler)
        try:
            status = command(options)
        finally:
            line.done()
        leave(status)
    for number in PASSED_ON:
        signal.signal(number, _passed_on(child))
    line.only_listen()
    status = _awaited(child, line)
    if status == -signal.SIGKILL and line.is_late:
        options.out = sys.stdout
        line.words.say(options)
        return line.words.status
    if status < 0:
        print(f"tamp: the command was ended by {signal.Signals(-status).name}", file=sys.stderr)
        return 128 - status
    if not line.told:
        print(f"tamp: {named} ended the program", file=sys.stderr)
        return BAD_INPUT
    return status


def _passed_on(child: int) -> Callable[[int, object], None]:
    asked = list[int]()

    def pass_on(number: int, _: object) -> None:
        os.kill(child, signal.SIGKILL if asked else number)  # who asks again means it
        asked.append(number)

    return pass_on


def _awaited(child: int, line: Line) -> int:
    """The exit status of a child process, or minus the signal that ended it; it is ended where it is late."""
    while True:
        line.listen(LOOK_S)
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            line.listen(0.0)
            return os.waitstatus_to_exitcode(status)
        if line.is_late:
            os.killpg(child, signal.SIGKILL)
