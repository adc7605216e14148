"""A process that ends when its parent does, however that ends, and one that ends what its children have left."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # from linux/prctl.h
GRACE_S, KILLED_S = 0.3, 1.0
"""How long those may take that end by themselves, as what they are for has ended, and those that are killed [s]."""


def end_with_parent() -> None:
    """Be killed when the parent ends, however it does; on Linux only."""
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def adopt_orphans() -> None:
    """Become the parent of what descendants leave that end, whatever group or session it is in; on Linux only."""
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def end_children(grace: float, but: Collection[int] = ()) -> None:
    """Wait a little for the children of this process, adopted ones among them, and kill what is left of them.

    Args:
        grace: how long they may take to end by themselves [s].
        but: numbers of processes that go on, such as those that a shell has begun before it became this process.
    """
    until = time.monotonic() + grace
    while (left := children().difference(but)) and time.monotonic() < until + KILLED_S:
        if time.monotonic() >= until:
            for child in left:
                with suppress(OSError):
                    os.kill(child, signal.SIGKILL)
        time.sleep(0.01)


def children() -> frozenset[int]:
    """Numbers of the children of this process that have not ended; none where the system does not tell."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    found: list[int] = []
    with suppress(OSError):
        for task in Path("/proc/self/task").iterdir():
            found += map(int, (task / "children").read_text().split())
    return frozenset(found)
