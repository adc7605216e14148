"""Many jobs in worker processes, a fresh one for each; a job that crashes, hangs or eats memory costs only itself.

Workers are forked from a server process that has imported the heavy libraries once and done nothing else, so that a
fresh process is cheap and no job sees what another left behind.
"""

from __future__ import annotations

import json
import logging
import math
import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import forkserver, resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, Literal

from tamp.batch.processes import Processes, available, kill_group, kill_tree, processes
from tamp.batch.worker import run_job
from tamp.errors import TampError

# Workers share the cores among themselves: threads inside a worker would only get in each other's way.
SINGLE_THREADED = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""What ends a batch from outside."""
LATE_S = 0.9
"""How long after its own deadline what a job is at may go on before the job is killed [s]."""
NO_SERVER = 255
"""The exit code of a worker whose fork server died, and the worker with it: no fault of the job's."""
DYING_S = 0.1
"""How long to wait for a fork server that is dying to be dead, some times over [s]."""
TRIES = 3
"""How often a job is begun whose worker dies with its fork server."""
MEMORY_WATCH_S = 0.25
"""How often the memory of workers is looked at where it is limited [s]."""


@dataclass(frozen=True)
class Job:
    """One call of the work function.

    Attributes:
        key: what the job is filed under; unique within a batch.
        arguments: JSON-like keyword arguments of the work function.
    """

    key: str
    arguments: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """How a job ended.

    Attributes:
        job: the job.
        ended: "returned", "raised", "crashed" (also: killed by someone), "timeout", "memory" or "full" (the disk is).
        value: what the work function returned; None unless it returned.
        message: why there is no value, in words.
        wall_s: how long it took [s].
    """

    job: Job
    ended: Literal["returned", "raised", "crashed", "timeout", "memory", "full"]
    value: Mapping[str, Any] | None
    message: str
    wall_s: float


def run_jobs(
    jobs: Iterable[Job],
    work: str,
    *,
    workers: int = 1,
    time_limit_s: float | None = None,
    memory_limit: int | None = None,
    preload: Sequence[str] = (),
) -> Iterator[Outcome]:
    """Run jobs in worker processes and yield each outcome as it comes.

    Closing the iterator, or an exception such as KeyboardInterrupt in it, ends all workers.

    Args:
        jobs: what to run, in this order.
        work: the work function as "package.module:function".
        workers: how many run at the same time.
        time_limit_s: a job that runs longer is killed with all its child processes [s].
        memory_limit: a job whose processes together have more resident memory is killed [bytes].
        preload: modules that the work imports anyway, imported once for all.

    Raises:
        TampError: for a memory limit on a system that does not show the memory of processes.
    """
    if memory_limit is not None and not available():
        raise TampError("a memory limit needs /proc, which this system does not have; leave the limit out")
    for name in SINGLE_THREADED:
        os.environ.setdefault(name, "1")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tamp.batch.worker", *preload])
    _start_server()
    waiting = deque((job, 1) for job in jobs)
    running: list[_Worker] = []
    looked = -math.inf
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                with _undisturbed():  # the fork server would complain of half a request
                    running.append(_Worker(context, *waiting.popleft(), work, memory_limit, time_limit_s))
            wait(
                [w.process.sentinel for w in running] + [w.connection for w in running],
                _patience(running, memory_limit),
            )
            seen = None
            if memory_limit is not None and time.monotonic() >= looked + MEMORY_WATCH_S:
                seen, looked = processes(), time.monotonic()
            with _undisturbed():  # Python drops an exception that a signal raises while it tidies up after a process
                running, ended, again = _ended_among(running, seen)
            waiting.extendleft(again)
            yield from ended
    finally:
        for worker in running:
            worker.kill()


def _ended_among(
    workers: Sequence[_Worker], seen: Processes | None
) -> tuple[list[_Worker], list[Outcome], list[tuple[Job, int]]]:
    """The workers that go on, how others ended, and the jobs to be tried again as their fork server died."""
    running: list[_Worker] = []
    ended: list[Outcome] = []
    again: list[tuple[Job, int]] = []
    for worker in workers:
        outcome = worker.outcome(seen)
        if outcome is None:
            running.append(worker)
        elif outcome.ended == "crashed" and worker.orphaned and worker.tries < TRIES:
            again.append((worker.job, worker.tries + 1))
        else:
            ended.append(outcome)
    return running, ended, again


def _start_server() -> None:
    """Start the server that workers are forked from, deaf to Ctrl-C even while it still imports: it ends with us."""
    resource_tracker.ensure_running()  # which would unblock the signal if it had to start within
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Let what ends the batch wait for the end of the block.

    Blocking the signals would not do: another thread would take them, and Python's handler run in the main one.
    """
    came: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():
        handled = [number for number in ENDING if callable(signal.getsignal(number))]
        before = {number: signal.signal(number, lambda sent, _: came.append(sent)) for number in handled}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for sent in came:
            signal.raise_signal(sent)


def _patience(running: Sequence[_Worker], memory_limit: int | None) -> float | None:
    """Until when nothing needs to be done [s]."""
    deadlines = [w.deadline for w in running if w.deadline < math.inf]
    until = max(0.0, min(deadlines) - time.monotonic()) if deadlines else None
    return until if memory_limit is None else min(MEMORY_WATCH_S, MEMORY_WATCH_S if until is None else until)


class _Worker:
    """A process at its one job."""

    def __init__(
        self, context: Any, job: Job, tries: int, work: str, memory_limit: int | None, time_limit_s: float | None
    ) -> None:
        self.job, self.tries = job, tries
        self._began = time.monotonic()
        self._limit = time_limit_s
        self._memory_limit = memory_limit
        self._end = math.inf if time_limit_s is None else self._began + time_limit_s
        self._until = math.inf
        self.connection: Connection
        self.connection, theirs = context.Pipe(duplex=False)
        arguments = (theirs, work, dict(job.arguments), logging.getLogger("tamp").getEffectiveLevel())
        self.process = _started(context, run_job, arguments, f"tamp {job.key}")
        theirs.close()

    @property
    def deadline(self) -> float:
        """When the job is killed if it has not ended, in time.monotonic() [s]."""
        return min(self._end, self._until)

    @property
    def orphaned(self) -> bool:
        """Whether the worker died with its fork server."""
        return bool(self.process.exitcode == NO_SERVER)

    def outcome(self, seen: Processes | None) -> Outcome | None:
        """How the job ended; None while it runs. Its memory counts where it is limited and somebody has looked."""
        alive = self.process.is_alive()  # asked first: what has ended has said all that it will say
        message = self._message()
        if message is not None:
            self.process.join(1.0)  # it has nothing left to do but to end
        elif alive:
            if time.monotonic() >= self.deadline:
                late = self._until < self._end
                self.kill()
                said = "planning did not end with its limit" if late else f"ended from outside after {self._limit:g} s"
                return self._ended("timeout", f"{said}, and was ended from outside" if late else said)
            used = 0 if seen is None else sum(seen.tree(self.process.pid).values())
            if self._memory_limit is not None and used > self._memory_limit:
                self.kill()
                return self._ended("memory", f"ended from outside at {self._memory_limit / 2**30:.3g} GiB of memory")
            return None
        self.kill()
        if message is None:
            return self._ended("crashed", _cause(self.process.exitcode))
        if "value" in message:
            return self._ended("returned", "", message["value"])
        if "full" in message:
            return self._ended("full", str(message["full"]))
        return self._ended("raised", str(message.get("error")))

    def kill(self) -> None:
        """End the process and everything it started."""
        (kill_tree if self.process.is_alive() else kill_group)(self.process.pid)
        self.process.join()
        self.connection.close()

    def _message(self) -> dict[str, Any] | None:
        """What the worker says of its end; on the way, by when what it is at must have ended."""
        try:
            while self.connection.poll():
                message = json.loads(self.connection.recv_bytes())
                if not isinstance(message, dict) or "until" not in message:
                    return message if isinstance(message, dict) else None
                self._until = math.inf if message["until"] is None else message["until"] + LATE_S
        except (EOFError, OSError, ValueError, TypeError):  # the other end is gone, perhaps in the middle of a message
            return None
        return None

    def _ended(self, ended: Any, message: str, value: Mapping[str, Any] | None = None) -> Outcome:
        return Outcome(self.job, ended, value, message, time.monotonic() - self._began)


def _started(context: Any, target: Callable[..., None], arguments: tuple[Any, ...], name: str) -> Any:
    """A process on its way; the fork server may die at any moment, and is then started again."""
    for last in (*[False] * 20, True):
        process = context.Process(target=target, args=arguments, name=name)
        try:
            process.start()
        except (OSError, EOFError):
            if last:
                raise
            time.sleep(DYING_S)
            _start_server()
        else:
            return process
    raise AssertionError("unreachable")


def _cause(exit_code: int | None) -> str:
    if exit_code is not None and exit_code < 0:
        with suppress(ValueError):
            return f"the worker was ended by {signal.Signals(-exit_code).name}"
    return f"the worker ended without a result (exit status {exit_code})"
