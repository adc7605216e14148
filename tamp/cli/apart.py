"""A command that runs somebody's code, in a process of its own: one that ends from below has not succeeded.

What the waiting process hears counts as far as it begins with a key, and the exit status is the one that the command
says it has come to: whatever else is written, closed, forked or registered makes no success. What the command leaves
behind is ended with it, on Linux also what has a session of its own.
"""

from __future__ import annotations

import argparse
import json
import os
import select
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn

from tamp.cli.status import BAD_INPUT, UNSOLVED
from tamp.cli.watchdog import LATE_S, LastWords
from tamp.parent import GRACE_S, adopt_orphans, children, end_children, end_with_parent

PASSED_ON = (signal.SIGINT, signal.SIGTERM, signal.SIGQUIT, signal.SIGHUP)
LOOK_S = 0.05
"""How often it is seen whether the command has ended [s]."""
LONGEST = 1 << 20
"""Of what is said without an end of the line no more is kept [bytes]."""


class Line:
    """On which a command tells the process that waits for it by when it must end, and that it has come to its end.

    Attributes:
        told: the exit status that it says it has come to by itself, or None.
        until: by when it must have ended, in time.monotonic() [s], or None.
        words: what it leaves then.
    """

    def __init__(self) -> None:
        self.told: int | None = None
        self.until: float | None = None
        self.words = LastWords(BAD_INPUT, "", {})
        self._heard, self._said = os.pipe()
        self._pipe = os.fstat(self._said)
        self._key = os.urandom(16).hex().encode()
        self._speaker = os.getpid()
        self._begun = b""

    def speak(self) -> None:
        """Be the process that says something; what is forked from it does not."""
        self._speaker = os.getpid()

    def tell(self, words: LastWords, until: float | None) -> None:
        """Say by when this process must have ended, and what it leaves otherwise."""
        self._say([until, words.status, words.sentence, dict(words.data)])

    def done(self, status: int) -> None:
        """Say that this process comes to an end by itself, with this exit status."""
        self._say(status)

    def _say(self, message: object) -> None:
        with suppress(OSError):  # a sampler has closed it, and may have opened another file: then nobody is told
            if os.getpid() == self._speaker and os.path.samestat(os.fstat(self._said), self._pipe):
                os.write(self._said, b"\n%s%s\n" % (self._key, json.dumps(message).encode()))

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
        self._begun = self._begun[-LONGEST:]
        for message in (json.loads(line.removeprefix(self._key)) for line in whole if line.startswith(self._key)):
            if isinstance(message, int):
                self.told = message
            else:
                self.until, *words = message
                self.words = LastWords(*words)


def apart(
    command: Callable[[argparse.Namespace], int],
    options: argparse.Namespace,
    leave: Callable[[int], NoReturn],
    named: str,
) -> int:
    """Run a command in a child process, and return the exit status that it says; that of an error where it says none.

    Args:
        command: takes the options, and returns its exit status.
        options: of the command; their `line` is set.
        leave: ends the child with that status.
        named: what the user names whose code it runs, such as "a sampler".
    """
    line = options.line = Line()
    handlers = {number: signal.getsignal(number) for number in PASSED_ON}
    adopt_orphans()
    others = children()
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)  # what the terminal sends is passed on once
        end_with_parent()
        line.speak()
        for number, handler in handlers.items():
            signal.signal(number, handler)
        status = UNSOLVED  # that of an exception
        try:
            status = command(options)
        except SystemExit as end:  # of a parser that finds the options wrong: success is returned
            status = end.code if isinstance(end.code, int) and end.code else status
            raise
        finally:
            line.done(status)
        leave(status)
    for number in PASSED_ON:
        signal.signal(number, _passed_on(child))
    line.only_listen()
    status = _awaited(child, line)
    end_children(0.0 if line.is_late else GRACE_S, others)
    if status == -signal.SIGKILL and line.is_late:
        options.out = sys.stdout
        line.words.say(options)
        return line.words.status
    if status < 0:
        print(f"tamp: the command was ended by {signal.Signals(-status).name}", file=sys.stderr)
        return 128 - status
    if line.told is None:
        print(f"tamp: {named} ended the program", file=sys.stderr)
        return BAD_INPUT
    return line.told


def _passed_on(child: int) -> Callable[[int, object], None]:
    asked = list[int]()

    def pass_on(number: int, _: object) -> None:
        with suppress(ProcessLookupError):
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
            for end in (os.killpg, os.kill):  # it may have left its group
                with suppress(OSError):
                    end(child, signal.SIGKILL)
