"""A worker's process tree, seen from outside through /proc: its memory, and its end."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

PROC = Path("/proc")


def available() -> bool:
    """Whether this system shows processes in /proc."""
    return (PROC / "self" / "stat").is_file()


@dataclass(frozen=True)
class Processes:
    """All processes of the system at a moment.

    Attributes:
        children: process -> those that it started and that still run.
        memory: process -> its resident memory [bytes].
    """

    children: Mapping[int, Sequence[int]] = field(default_factory=dict)
    memory: Mapping[int, int] = field(default_factory=dict)

    def tree(self, pid: int) -> dict[int, int]:
        """A process and all its descendants -> resident memory [bytes]; one may have a session of its own."""
        found = [pid]
        for member in found:
            found.extend(self.children.get(member, ()))
        return {member: self.memory.get(member, 0) for member in found}


def processes() -> Processes:
    """What runs now; nothing where the system does not show it."""
    children: dict[int, list[int]] = {}
    memory: dict[int, int] = {}
    for entry in PROC.iterdir() if available() else ():
        if entry.name.isdigit():
            with suppress(OSError, IndexError, ValueError):  # it may end while we look
                # The second field, the command in parentheses, may hold anything: count from behind it.
                rest = (entry / "stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
                children.setdefault(int(rest[1]), []).append(int(entry.name))
                memory[int(entry.name)] = int(rest[21]) * os.sysconf("SC_PAGE_SIZE")
    return Processes(children, memory)


def tree(pid: int) -> dict[int, int]:
    """A process and all its descendants now -> resident memory [bytes]."""
    return processes().tree(pid)


def kill_group(pid: int) -> None:
    """End what is left of a process group by the process that led it; its other descendants are nobody's any more."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)


def kill_tree(pid: int) -> None:
    """End a process, its group and all its descendants."""
    members = tree(pid)
    kill_group(pid)
    for member in members:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(member, signal.SIGKILL)
