"""The process above one that is not isolated: orphans come to it, and it ends them all. A program of its own."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36


def main(command: Sequence[str]) -> int:
    """Run a command and, when it has ended, end what it left; the exit status is the command's."""
    libc = ctypes.CDLL(None)
    libc.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    libc.prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    signal.signal(signal.SIGTERM, lambda *_: _end(143))
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.setsid()
        os.execv(command[0], list(command))
    while True:
        pid, status = os.wait()
        if pid == child:
            _end(os.WEXITSTATUS(status) if os.WIFEXITED(status) else 128 + os.WTERMSIG(status))


def children(pid: int) -> list[int]:
    """Processes that a process is the parent of; none of one that has ended."""
    found: list[int] = []
    with suppress(OSError):  # it may end while it is looked at
        for task in [*Path(f"/proc/{pid}/task").iterdir()]:
            with suppress(OSError):
                found += [int(word) for word in (task / "children").read_text().split()]
    return found


def _end(status: int) -> None:
    """Kill until nothing is left: what is orphaned on the way comes here."""
    while left := children(os.getpid()):
        for pid in left:
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        while True:
            try:
                if os.waitpid(-1, os.WNOHANG)[0] == 0:
                    break
            except ChildProcessError:
                break
    os._exit(status)


if __name__ == "__main__":
    main(sys.argv[1:])
