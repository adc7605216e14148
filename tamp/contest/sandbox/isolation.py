"""What a sandbox is: something that turns a command into one that runs where it can do no harm."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal, Protocol

COUNTS_BY_NAMESPACE = (5, 14)
"""The first version of Linux that holds RLIMIT_NPROC against the processes of a user in a namespace."""

MOST_PENDING = 1024
"""Timers and signals that wait; the kernel counts them for the server's user, who has none left when all are used."""

NO_CORE = 1
"""The limit of a core file by which there is none, and no program of the machine's is started to take it: by 0 one is
for each crash, as root and outside of the sandbox, where the machine has one (fs/coredump.c of Linux)."""

DEVICES = ("null", "zero", "full", "random", "urandom")
"""What there is of /dev inside."""

Reason = Literal[
    "finished", "raised", "died", "time", "processor", "answers", "idle", "wall", "memory", "processes", "output",
    "protocol", "start",
]  # fmt: skip
"""How a run of a solution ended.

"finished": `run` returned. "raised": it raised an exception. "died": the process ended by itself, or by a signal.
"time": the simulated time was over. "processor", "answers", "idle", "wall", "memory", "processes", "output": it went
over a limit.
"protocol": what it sent was none of the API's messages. "start": it did not begin to speak.
"""


ENVIRONMENT: Mapping[str, str] = MappingProxyType(
    {"PATH": "/usr/bin:/bin", "HOME": "/tmp", "USER": "solution", "LANG": "C.UTF-8"}
)
"""The environment of a solution."""


def visible(text: str) -> str:
    """Text in one line in which everything can be seen: no control characters, nor what turns the direction."""
    return "".join(c if c.isprintable() else " " if c.isspace() else "\ufffd" for c in text)


@dataclass(frozen=True)
class Ending:
    """How a run of a solution ended, and more of it in words.

    The words may be the solution's own, and go to terminals and pages: what cannot be seen is replaced in them.
    """

    reason: Reason
    message: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "message", visible(self.message))


@dataclass(frozen=True)
class Limits:
    """The most that a solution's processes may use, all together.

    How busy the machine is shall decide nothing: who computes has `processor_s`, who waits for the robot has the
    simulated time, or `answers_s` where that hardly passes, who does neither has `idle_s`. Real time ends only what
    these do not.

    Attributes:
        processor_s: processor time [s].
        answers_s: processor time of the server's for calls that take hardly any simulated time, such as pictures [s].
        idle_s: real time in which none of them computes, and no answer of the server's is waited for [s].
        wall_s: real time, the simulator's included [s].
        memory_mb: memory, files in its temporary folder included [MiB].
        processes: processes and threads.
        output_kb: what it may print [KiB].
        scratch_mb: what it may write into its temporary folder [MiB].
    """

    processor_s: float = 1200.0
    answers_s: float = 1200.0
    idle_s: float = 120.0
    wall_s: float = 7200.0
    memory_mb: int = 4096
    processes: int = 128
    output_kb: int = 1024
    scratch_mb: int = 256

    def rlimits(self, *, isolated: bool) -> dict[str, int]:
        """What the kernel limits for each process by itself: the name in `resource` -> value.

        Args:
            isolated: it has a user namespace of its own, in which the kernel counts its processes.
        """
        each = {
            "RLIMIT_CORE": NO_CORE,
            "RLIMIT_CPU": round(self.processor_s) + 1,
            "RLIMIT_DATA": self.memory_mb << 20,
            "RLIMIT_FSIZE": self.scratch_mb << 20,
            "RLIMIT_NOFILE": 256,
            "RLIMIT_SIGPENDING": MOST_PENDING,
        }
        # Older kernels count the user's processes everywhere; and of root's, none counts.
        if isolated and _release() >= COUNTS_BY_NAMESPACE:
            each["RLIMIT_NPROC"] = self.processes + 1  # so that one too many is seen, and named
        return each


def _release() -> tuple[int, ...]:
    """The kernel's version: its first two numbers."""
    return tuple(int(number) for number in re.findall(r"\d+", os.uname().release)[:2])


@dataclass(frozen=True)
class Mount:
    """A file or folder outside, and where it is seen inside, to be read only."""

    source: Path
    target: str


@dataclass(frozen=True)
class Room:
    """What there is to be seen inside.

    Attributes:
        mounts: in the order in which they are made.
        hidden: folders inside that are to be empty.
        links: where symbolic links stand -> what they point to.
        scratch_mb: size of /tmp, the only place to write to [MiB].
    """

    mounts: tuple[Mount, ...]
    hidden: tuple[str, ...] = ()
    links: tuple[tuple[str, str], ...] = ()
    scratch_mb: int = 256


class Sandbox(Protocol):
    """A way to isolate."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def isolates(self) -> bool:
        """Whether network and file system are out of reach."""

    def missing(self) -> str:
        """Why it cannot be used on this machine; empty where it can."""

    def command(self, room: Room, command: Sequence[str]) -> list[str]:
        """The command that runs `command` in a room, keeps open descriptors, and ends with all of its children."""

    def inside(self, room: Room, target: str) -> str:
        """What the file or folder that is mounted at `target` is called inside."""
