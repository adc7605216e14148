"""A solution's process as the server sees it: started, watched, listened to, and ended with all its children."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import TracebackType

from tamp.contest.sandbox import cgroups
from tamp.contest.sandbox.isolation import Ending, Limits, Room, Sandbox
from tamp.contest.sandbox.reaper import children
from tamp.errors import TampError, told

LOOK_S = 0.2
"""Time between two looks at what the processes use [s]."""

END_S = 5.0
"""How long the kernel may take to end killed processes [s]."""

MOST_FILES = 100_000
"""In a temporary folder; an empty one takes a kilobyte of the kernel's memory, which no process is charged for."""

MAPPING_BYTES = 256
"""What the kernel keeps of each mapping of a process's memory, however small; no process is charged for it."""

HUGE = (b"Private_Hugetlb:", b"Shared_Hugetlb:")
"""Pages of which a machine may have set some aside, which are in no set size."""

MOST_PIPES = 256
"""Each may take 16 of the 16,384 pages that there are for all pipes of a user (/proc/sys/fs/pipe-user-pages-soft), the
server's and other runs' included, which hold two pages each once these are taken."""

QUEUE = Path("/proc/sys/net/core/wmem_default")
"""What a socket may hold of what was sent and not read [bytes]: memory that no process is charged for."""

TICKS = os.sysconf("SC_CLK_TCK")

Descriptor = tuple[int, int]
"""What is open, by its device and number."""

Spent = dict[tuple[int, bytes], int]
"""A process by its number and start -> the processor time it was last seen to have used itself [ticks]."""


class SandboxedProcess:
    """A running command; a context manager, at whose end nothing of it is left.

    Raises:
        TampError: at the end, where it could not be watched and was ended for that.

    Args:
        sandbox: where it runs.
        room: what it sees.
        command: what is run.
        limits: what it may use.
        descriptor: of the socket that it keeps.
    """

    def __init__(
        self, sandbox: Sandbox, room: Room, command: Sequence[str], limits: Limits, descriptor: int | None = None
    ) -> None:
        self._limits, self._began = limits, time.monotonic()
        self._stopped: Ending | None = None
        self._failure: Exception | None = None
        self._lock, self._done = threading.Lock(), threading.Event()
        self._output, self._spent = bytearray(), Spent()
        self._idle_looks, self._waits_for_us = 0, False
        self._group = cgroups.make(limits)
        join = "".join(f"echo $$ > {file} && " for file in self._group.files) if self._group else ""
        self._process = subprocess.Popen(
            ["/bin/sh", "-c", f'{join}exec "$@"', "sh", *sandbox.command(room, command)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=() if descriptor is None else (descriptor,),
            env={"PATH": os.environ.get("PATH", os.defpath)},
            start_new_session=True,
        )
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._listen, self._watch)]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> SandboxedProcess:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()
        if error is None and self._failure is not None:  # how it ended is no doing of its own
            raise TampError(f"a solution could not be watched: {told(self._failure)}") from self._failure

    @property
    def output(self) -> bytes:
        """What it has printed, up to the limit."""
        return bytes(self._output)

    @property
    def time_left(self) -> float:
        """Real time until its limit [s]."""
        return self._limits.wall_s - (time.monotonic() - self._began)

    @property
    def stopped(self) -> Ending | None:
        """Why it was stopped; None where it was not."""
        return self._stopped

    @contextmanager
    def waiting_for_us(self) -> Iterator[None]:
        """While the block runs the solution waits for an answer, and is not idle."""
        self._waits_for_us = True
        try:
            yield
        finally:
            self._waits_for_us = False

    def wait(self, timeout_s: float) -> int | None:
        """The exit status, negative for a signal; None where it still runs."""
        try:
            return self._process.wait(max(0.0, timeout_s))
        except subprocess.TimeoutExpired:
            return None

    def stop(self, ending: Ending) -> None:
        """Kill it; the first reason counts."""
        with self._lock:
            self._stopped = self._stopped or ending
        self._kill()

    def end(self) -> None:
        """Kill what is left, and wait until it is gone."""
        self._kill()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(END_S)
        self._done.set()
        for thread in self._threads:
            thread.join(END_S)
        if self._group is not None:
            self._look_at_group()
            self._group.kill()
            self._group.remove()

    def _kill(self) -> None:
        # A reaper ends its children at SIGTERM; namespaces end with their first process.
        for pid in self._tree()[::-1]:
            with suppress(OSError):
                os.kill(pid, signal.SIGTERM if pid == self._process.pid else signal.SIGKILL)
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(0.5)
        with suppress(OSError):
            os.killpg(self._process.pid, signal.SIGKILL)
        if self._group is not None:
            self._group.kill()

    def _listen(self) -> None:
        """Keep what is printed, and stop what prints too much."""
        pipe = self._process.stdout
        assert pipe is not None
        most = self._limits.output_kb << 10
        while data := os.read(pipe.fileno(), 1 << 16):
            self._output += data[: most - len(self._output)]
            if len(self._output) >= most:
                self.stop(Ending("output", f"printed more than {self._limits.output_kb} KiB"))
        pipe.close()

    def _watch(self) -> None:
        try:
            while not self._done.wait(LOOK_S) and self._process.poll() is None:
                self._look()
            self._look_at_group()
        except Exception as error:
            self._failure = error
            self._kill()  # nothing runs that nobody watches

    def _look(self) -> None:
        """Stop it where it uses too much; what the group limits, the kernel has limited already."""
        if self.time_left <= 0:
            self.stop(Ending("wall", f"ran longer than {self._limits.wall_s:g} s"))
        tree = self._tree()
        # Looks are counted, not what passes between them: one that comes late is the machine's doing.
        self._idle_looks += not (self._waits_for_us or any(_computes(pid) for pid in tree))
        if self._idle_looks * LOOK_S > self._limits.idle_s:
            self.stop(Ending("idle", f"did nothing for {self._limits.idle_s:g} s of real time, all in all"))
        processes, processor, memory, pipes = usage(tree, self._spent)
        if processor > self._limits.processor_s:
            self.stop(Ending("processor", f"used more than {self._limits.processor_s:g} s of processor time"))
        if memory > self._limits.memory_mb << 20:
            self.stop(Ending("memory", f"used more than {self._limits.memory_mb} MiB"))
        if processes > self._limits.processes:
            self.stop(Ending("processes", f"started more than {self._limits.processes} processes and threads"))
        if pipes > MOST_PIPES:
            self.stop(Ending("memory", f"opened more than {MOST_PIPES} pipes"))
        if any(_files_made(pid) > MOST_FILES for pid in tree):  # any of them may just have ended
            self.stop(Ending("memory", f"made more than {MOST_FILES} files"))
        self._look_at_group()

    def _look_at_group(self) -> None:
        if self._group is None:
            return
        if self._group.out_of_memory():
            self.stop(Ending("memory", f"used more than {self._limits.memory_mb} MiB"))
        if self._group.too_many():
            self.stop(Ending("processes", f"started more than {self._limits.processes} processes and threads"))

    def _tree(self) -> list[int]:
        """The process and all under it, parents first."""
        found = [self._process.pid]
        for pid in found:
            found += children(pid)
        return found


def usage(pids: Sequence[int], spent: Spent) -> tuple[int, float, int, int]:
    """Processes and threads, processor time [s] with that of children that have ended, memory [bytes], and pipes.

    Memory that processes share counts once: their proportional set sizes are added, the kernel's tables of their pages,
    its notes of their mappings, and for each socket as much as its queue may hold, be it open or not.

    Args:
        pids: processes.
        spent: of all that were seen before; changed. A parent that ignores its children's end is not charged for them.
    """
    count, processor, memory = 0, 0, 0
    sockets, pipes = set[Descriptor](), set[Descriptor]()
    for pid in pids:
        with suppress(OSError, ValueError, IndexError):
            words = Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()  # its name is in no encoding
            own, of_children = sum(map(int, words[11:13])), sum(map(int, words[13:15]))
            spent[pid, words[19]] = own
            processor += own + of_children
            count += int(words[17])
            memory += _memory(pid)
            try:
                found = _open(pid)
            except PermissionError:  # it does not let itself be looked into: all that it holds may be sockets
                sockets |= {(pid, number) for number in range(_number(pid, "status", b"FDSize:"))}
                continue
            sockets |= found.get(stat.S_IFSOCK, set())
            pipes |= found.get(stat.S_IFIFO, set())
    held = max(len(sockets), _sockets_inside(pids))
    return count, max(processor, sum(spent.values())) / TICKS, memory + held * _queue(), len(pipes)


def _computes(pid: int) -> bool:
    """Whether a thread of a process has the processor, or would have it were the machine not busy."""
    for thread in Path(f"/proc/{pid}/task").glob("*/stat"):
        with suppress(OSError):  # it has just ended
            if thread.read_bytes().rpartition(b")")[2].split(maxsplit=1)[0] == b"R":
                return True
    return False


def _files_made(pid: int) -> int:
    """Files in the temporary folder that a process sees; 0 where this user may not look, or it counts none."""
    with suppress(OSError):
        folder = f"/proc/{pid}/root/tmp"
        if Path(folder).stat().st_dev != Path("/tmp").stat().st_dev:  # its own one
            found = os.statvfs(folder)
            return found.f_files - found.f_ffree
    return 0


def _memory(pid: int) -> int:
    """A process's share of memory, what is swapped out and the tables of its pages and mappings included [bytes]."""
    mappings = Path(f"/proc/{pid}/maps").read_bytes().count(b"\n")
    pages = _number(pid, "smaps_rollup", b"Pss:", b"SwapPss:", *HUGE) + _number(pid, "status", b"VmPTE:")
    return (pages << 10) + mappings * MAPPING_BYTES


def _number(pid: int, file: str, *fields: bytes) -> int:
    """The sum of fields of a file of the kernel's on a process; its name, in some of them, is in no encoding."""
    lines = Path(f"/proc/{pid}/{file}").read_bytes().split(b"\n")
    return sum(int(line.split()[1]) for line in lines if line.startswith(fields))


def _open(pid: int) -> dict[int, set[Descriptor]]:
    """What a process holds open: its kind, as `stat` has it -> which ones."""
    found: dict[int, set[Descriptor]] = {}
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(OSError):  # it has just been closed
            seen = entry.stat()
            found.setdefault(stat.S_IFMT(seen.st_mode), set()).add((seen.st_dev, seen.st_ino))
    return found


def _sockets_inside(pids: Sequence[int]) -> int:
    """Sockets in the network namespace of a sandbox, with those that wait to be accepted or lie in a message.

    Args:
        pids: its processes, parents first; 0 where they have no namespace of their own.
    """
    for pid in pids[::-1]:  # the first ones may be outside
        with suppress(OSError):
            if Path(f"/proc/{pid}/ns/net").stat().st_ino != Path("/proc/self/ns/net").stat().st_ino:
                return Path(f"/proc/{pid}/net/unix").read_bytes().count(b"\n") - 1
    return 0


@cache
def _queue() -> int:
    return int(QUEUE.read_text())
