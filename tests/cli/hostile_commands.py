"""Commands that do to their own process, and to the one that waits for it, what hostile code could do."""

from __future__ import annotations

import argparse
import atexit
import os
import signal
import sys
import time
from contextlib import suppress

from tamp.cli.apart import apart
from tamp.cli.watchdog import LastWords

LEAST, MOST = 3, 64  # file descriptors


def writes_into_every_pipe(line):
    """Say in its place that all is done, and what is no message at all, and end."""
    for descriptor in range(LEAST, MOST):
        with suppress(OSError):
            os.write(descriptor, b'[]\n0\n{"\n\xff\n[null, 0, "", {}]\n' + 9 * b"[" * 1000)
    os._exit(0)


def closes_every_descriptor(line):
    """Nothing can be told then; the next file that is opened takes the number of what was closed."""
    os.closerange(LEAST, MOST)
    for _ in range(LEAST, MOST):
        os.open("opened", os.O_WRONLY | os.O_CREAT)
    return 0


def comes_to_an_end(line):
    """Do nothing of that."""
    return 0


def fails_and_ends_well(line):
    """Be a failure that turns into a success as the interpreter ends."""
    atexit.register(os._exit, 0)
    return 1


def forks_one_that_comes_to_an_end(line):
    """Have a copy of the process raise what ends the command, and end from below."""
    if os.fork() == 0:
        raise ValueError("in the copy")
    os.wait()
    os._exit(0)


def exits_well(line):
    """Raise what ends a program as if all were well."""
    sys.exit(0)


def leaves_a_session_behind(line):
    """Leave somebody behind, in a session of its own, who would go on."""
    _leave_behind()
    return 0


def goes_on_in_another_group(line):
    """Go on past the limit in the group of who waits, blocking all signals, and leave somebody behind."""
    line.tell(LastWords(1, "it is late", {}), time.monotonic() + 0.1)
    os.setpgid(0, os.getpgid(os.getppid()))
    signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    _leave_behind()
    time.sleep(60)


def _leave_behind():
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            print(os.getpid(), flush=True)
            time.sleep(60)
        os._exit(0)
    time.sleep(0.2)


def main(name: str) -> None:
    options = argparse.Namespace(json=None)
    sys.exit(apart(lambda o: globals()[name](o.line), options, sys.exit, "a sampler"))


if __name__ == "__main__":
    main(sys.argv[1])
