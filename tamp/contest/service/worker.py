"""A worker: takes one run after the other from the queue, does it, and records what came of it."""

from __future__ import annotations

import errno
import logging
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from tamp.contest.evaluation.trial import NotBegunError, Trial, cannot_load, run_trial
from tamp.contest.package import Package, unpack
from tamp.contest.sandbox.isolation import Sandbox
from tamp.contest.service import films, queue
from tamp.contest.service.contest import Contest
from tamp.contest.service.store import OUT_OF_REACH, DamagedError, Store, StoreFullError
from tamp.contest.service.submissions import package_path
from tamp.contest.service.withdrawn import withdraw_unloadable
from tamp.results import Result, to_json

LOG = logging.getLogger(__name__)

T = TypeVar("T")

TRIES = 3
"""How often a run is begun before it counts as one that cannot be done."""

MOST_CLAIMS = 8
"""A run that was begun so often, and whose workers ended before it did, ends them: it is not begun again."""

IDLE_S = 1.0
"""Time between two looks into an empty queue [s]."""

SHORTAGES = frozenset(
    getattr(errno, name) for name in ("ENOSPC", "EDQUOT", "EROFS", "EIO", "EMFILE", "ENFILE", "ENOMEM", "EAGAIN")
)
"""Of disk, handles, memory or processes: the machine's, for which no run is to pay."""


class _Stopped(Exception):  # noqa: N818  the end of a worker whose database is gone
    pass


@dataclass(frozen=True)
class Worker:
    """What a worker works with.

    Attributes:
        store: the database.
        contest: rules and tasks.
        data: the service's folder.
        sandbox: where solutions run.
        lease_s: see `tamp.contest.service.queue`.
        stop: whether it shall end, asked between runs and while the database does not answer.
    """

    store: Store
    contest: Contest
    data: Path
    sandbox: Sandbox
    lease_s: float = queue.LEASE_S
    stop: Callable[[], bool] = lambda: False

    def run(self, *, until_empty: bool = False) -> None:
        """Work until told to stop, or until nothing is left to do but what is put off again and again."""
        with suppress(_Stopped):
            self._run(until_empty)

    def _run(self, until_empty: bool) -> None:
        while not self.stop():
            held = self._patiently(lambda: queue.claim(self.store, self.lease_s))
            if held is not None:
                self.do(held)
            elif self._patiently(lambda: films.make_one(self.store, self.contest, self.data)):
                continue
            elif until_empty and not self._patiently(lambda: queue.waiting(self.store)):
                return
            else:
                time.sleep(IDLE_S)

    def do(self, held: queue.Claim) -> None:
        """Do a run that is held, and record it."""
        if held.claims > MOST_CLAIMS:
            self._give_up(held, f"{MOST_CLAIMS} workers ended while they did this run")
            return
        with self._held(held):
            trial = self._trial(held)
        if trial is None:
            return
        result = replace(trial.result, task=held.task, message=self._message(held, trial))
        log = self._log(held, trial)
        if self._patiently(lambda: queue.finish(self.store, held, to_json(result), log)):
            LOG.info("%s %s %s %d: %s", held.submission, held.task, held.simulator, held.run, result.message or "done")
            films.keep(self.data, held.trial, trial.frames)

    def _trial(self, held: queue.Claim) -> Trial | None:
        """The run; None where the server itself failed and it is to be tried again."""
        rules = self.contest.rules
        try:
            task = self.contest.entry(held.kind, held.task).task
            package_file = package_path(self.data, held.sha256, Path(held.file).suffix.lower())
            with tempfile.TemporaryDirectory(prefix="tamp-solution-") as folder:
                package = unpack(package_file, Path(folder) / "solution", rules.uploads)
                if held.kind == "contest" and self._withdrawn(held, package):
                    return None
                trial = run_trial(
                    task,
                    package,
                    rules=rules,
                    simulator=held.simulator,
                    run=held.run,
                    sandbox=self.sandbox,
                    film=True,
                )
        except Exception as error:  # a run that the server cannot do must not keep it from others
            self._failed(held, error)
            return None
        return trial

    def _withdrawn(self, held: queue.Claim, package: Package) -> bool:
        """Whether a submission was withdrawn since it cannot be loaded; it has seen nothing of a hidden task yet."""
        if not self._patiently(lambda: queue.untried(self.store, held)):
            return False
        wrong, _ = cannot_load(package, self.contest.rules, self.sandbox)
        if not wrong:
            return False
        why, most = f"it cannot be loaded: {wrong}", self.contest.rules.uploads.trials_a_month
        gone = self._patiently(lambda: withdraw_unloadable(self.store, held, why, most))
        LOG.info("%s: %s%s", held.submission, why, ", withdrawn" if gone else "")
        return gone

    def _failed(self, held: queue.Claim, error: Exception) -> None:
        """Have a run that failed on the server tried again: a few times, or later where the machine lacks something."""
        cause = error.__cause__ or error
        if isinstance(error, NotBegunError) or (isinstance(cause, OSError) and cause.errno in SHORTAGES):
            pause_s = self._patiently(lambda: queue.put_off(self.store, held, str(error)))
            LOG.error(
                "run %d of %s could not be begun, it is tried again in %g s: %s",
                held.trial, held.submission, pause_s, error,
            )  # fmt: skip
            time.sleep(IDLE_S)
            return
        LOG.error("run %d of %s failed on the server", held.trial, held.submission, exc_info=error)
        if held.claims < TRIES:
            self._patiently(lambda: queue.give_back(self.store, held))
            time.sleep(IDLE_S)
            return
        self._give_up(held, f"the server could not do this run: {type(error).__name__}")

    def _give_up(self, held: queue.Claim, message: str) -> None:
        """Record that a run cannot be done, so that others have their turn."""
        LOG.error("run %d of %s is given up: %s", held.trial, held.submission, message)
        result = Result(held.task, held.run, "error", simulator=held.simulator, message=message)
        self._patiently(lambda: queue.finish(self.store, held, to_json(result), message))

    def _message(self, held: queue.Claim, trial: Trial) -> str:
        """What is said of how it ended; not in the solution's words where it may say nothing of a hidden task."""
        mute = held.kind == "contest" and not self.contest.rules.contest_log_kb
        return trial.ending.reason if mute and trial.result.message else trial.result.message

    def _log(self, held: queue.Claim, trial: Trial) -> str:
        most = self.contest.rules.limits.output_kb if held.kind == "trial" else self.contest.rules.contest_log_kb
        return trial.log[: most << 10].decode("utf-8", errors="replace").replace("\0", "\ufffd")

    @contextmanager
    def _held(self, held: queue.Claim) -> Iterator[None]:
        """Renew the lease as long as the block runs."""
        done = threading.Event()

        def renew() -> None:
            while not done.wait(self.lease_s / 4):
                with suppress(*OUT_OF_REACH, StoreFullError, DamagedError):  # soon it is tried again, or recorded
                    queue.renew(self.store, held, self.lease_s)

        thread = threading.Thread(target=renew, daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()

    def _patiently(self, action: Callable[[], T]) -> T:
        """Do something with the database, again and again while it is full or out of reach, which is said once."""
        told = ""
        while True:
            try:
                done = action()
            except (*OUT_OF_REACH, StoreFullError) as error:  # noqa: PERF203  waiting is what it is for
                if self.stop():
                    raise _Stopped from error
                if told != (told := str(error).splitlines()[0]):
                    LOG.warning("the database does not answer, trying again: %s", told)
                time.sleep(5 * IDLE_S)
            else:
                if told:
                    LOG.warning("the database answers again")
                return done
