"""Limits on all processes of a solution together by control groups, where this user may make them (version 1 or 2)."""

from __future__ import annotations

import os
import signal
import time
import uuid
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tamp.contest.sandbox.isolation import Limits

ROOT = Path("/sys/fs/cgroup")
PREFIX = "tamp-contest-"

STALE_S = 60.0
"""An empty group that is older than this was left behind by a server that was killed [s]."""


@dataclass(frozen=True)
class ControlGroup:
    """A group for one run.

    Attributes:
        memory, pids: its folders; the same one in version 2.
    """

    memory: Path
    pids: Path

    @property
    def files(self) -> list[str]:
        """Where a process writes its number to join."""
        return [str(folder / "cgroup.procs") for folder in dict.fromkeys((self.memory, self.pids))]

    def out_of_memory(self) -> bool:
        """Whether the kernel has killed a process for memory."""
        return _counter(self.memory / "memory.oom_control", "oom_kill") > 0 or (
            _counter(self.memory / "memory.events", "oom_kill") > 0
        )

    def too_many(self) -> bool:
        """Whether the kernel has refused a process."""
        return _counter(self.pids / "pids.events", "max") > 0

    def kill(self) -> None:
        """Kill every process in it."""
        for folder in dict.fromkeys((self.memory, self.pids)):
            with suppress(OSError):
                for line in (folder / "cgroup.procs").read_text().split():
                    with suppress(OSError):
                        os.kill(int(line), signal.SIGKILL)

    def remove(self) -> None:
        """Remove the empty group; one that the kernel still empties is left to the next `make`."""
        for folder in dict.fromkeys((self.memory, self.pids)):
            with suppress(OSError):
                folder.rmdir()


def make(limits: Limits) -> ControlGroup | None:
    """A new group with limits; None where there are none to be had."""
    parents = _parents()
    if parents is None:
        return None
    for parent in parents:
        for stale in parent.glob(f"{PREFIX}*"):
            with suppress(OSError):  # one in use cannot be removed; a new one may have nobody in it yet
                if time.time() - stale.stat().st_mtime > STALE_S:
                    stale.rmdir()
    name = f"{PREFIX}{uuid.uuid4().hex[:12]}"
    group = ControlGroup(parents[0] / name, parents[1] / name)
    try:
        for folder in dict.fromkeys((group.memory, group.pids)):
            folder.mkdir()
        (group.pids / "pids.max").write_text(str(limits.processes))
        size = str(limits.memory_mb << 20)
        two = group.memory / "memory.max"
        (two if two.exists() else group.memory / "memory.limit_in_bytes").write_text(size)
    except OSError:
        group.remove()
        return None
    return group


def _parents() -> tuple[Path, Path] | None:
    """The folders in which groups for memory and processes can be made."""
    if (ROOT / "cgroup.controllers").is_file():
        with suppress(OSError):
            if {"memory", "pids"} <= set((ROOT / "cgroup.subtree_control").read_text().split()):
                return (ROOT, ROOT) if os.access(ROOT, os.W_OK) else None
        return None
    pair = ROOT / "memory", ROOT / "pids"
    return pair if all((folder / "cgroup.procs").is_file() and os.access(folder, os.W_OK) for folder in pair) else None


def _counter(path: Path, name: str) -> int:
    with suppress(OSError):
        for line in path.read_text().splitlines():
            word, _, value = line.partition(" ")
            if word == name:
                return int(value)
    return 0
