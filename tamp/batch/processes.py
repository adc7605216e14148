"""A worker's process tree, seen from outside through /proc: its memory, and its end."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

PROC = Path("/proc")


def available() -> bool:
    """Whether this system shows processes in /proc."""
    return (PROC / "self" / "stat").is_file()


def tree(pid: int) -> dict[int, int]:
    """A process and all its descendants -> resident memory [bytes]; a descendant may have a session of its own."""
    children: dict[int, list[int]] = {}
    memory: dict[int, int] = {}
    for entry in PROC.iterdir() if available() else ():
        if entry.name.isdigit():
            with suppress(OSError, IndexError, ValueError):  # it may end while we look
                # The second field, the command in parentheses, may hold anything: count from behind it.
                rest = (entry / "stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
                children.setdefault(int(rest[1]), []).append(int(entry.name))
                memory[int(entry.name)] = int(rest[21]) * os.sysconf("SC_PAGE_SIZE")
    found = [pid]
    for member in found:
        found.extend(children.get(member, ()))
    return {member: memory.get(member, 0) for member in found}


def kill_tree(pid: int) -> None:
    """End a process, its group and all its descendants."""
    members = tree(pid)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)
    for member in members:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(member, signal.SIGKILL)
