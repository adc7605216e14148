"""All processes of the service: the web server here, workers beside it, each started again where it ends."""

from __future__ import annotations

import logging
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from tamp.contest.evaluation.evaluate import require_doable
from tamp.contest.sandbox.isolation import Sandbox
from tamp.contest.service import films
from tamp.contest.service.contest import load_contest
from tamp.contest.service.queue import PutOff, Renewal, put_off_now, refresh, settled
from tamp.contest.service.scratch import alone, at_work, scratch_folder
from tamp.contest.service.store import open_store
from tamp.contest.service.submissions import require_packages
from tamp.contest.service.withdrawn import restore
from tamp.contest.service.worker import Worker
from tamp.errors import TampError

LOG = logging.getLogger(__name__)

RULES = "contest.yaml"
AGAIN_S = 1.0
"""How long after its end a worker is started again [s]; twice as long after each further one that fails at once."""

LONGEST_PAUSE_S = 60.0
"""At most so long [s]; a worker that has lived longer did not fail at once."""

LOOK_S = 0.2
"""Time between two looks at whether a worker has ended [s]."""


def rules_file(data: Path) -> Path:
    """The rules of a data folder.

    Raises:
        TampError: where there are none.
    """
    path = data / RULES
    if not path.is_file():
        raise TampError(f"{path}: there are no rules; write them, or begin with: tamp contest new {data}")
    return path


def work(
    data: Path,
    database: str | None,
    sandbox: Sandbox,
    lease_s: float,
    *,
    until_empty: bool = False,
    parent: int | None = None,
) -> PutOff | None:
    """Be a worker, until terminated; a run that is being done then is finished first.

    Args:
        data: the folder with the rules and the packages.
        database: URL; SQLite in `data` where it is None.
        sandbox: where solutions run.
        lease_s: how long it may be silent before its run is given to another worker [s].
        until_empty: end when every run is done, or cannot be begun.
        parent: end when the process of this number, which made sure that solutions can be run and started it, ends.

    Returns:
        What is left in the queue since it cannot be begun.

    Raises:
        TampError: where no solution can be run.
    """
    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())

    def ended() -> bool:
        return stop.is_set() or (parent is not None and os.getppid() != parent)

    rules = rules_file(data)
    with at_work(data), scratch_folder(data) as folder:
        contest, store = load_contest(rules), open_store(data, database)
        require_packages(store, data)
        contest = settled(store, contest)
        tempfile.tempdir = str(folder.resolve())  # the process's own: whatever it makes goes with it
        if parent is None:
            require_doable(contest.entries["contest"][0].task, contest.rules, sandbox)
        Worker(store, contest, data, sandbox, lease_s, ended).run(until_empty=until_empty)
        return put_off_now(store) if until_empty and not ended() else None


def again(data: Path, database: str | None, *, everything: bool, restored: Sequence[str] = ()) -> Renewal:
    """Hold all submissions against rules and tasks as they are now; the service must not run meanwhile.

    Args:
        data: the folder with the rules and the packages.
        database: URL; SQLite in `data` where it is None.
        everything: do every run anew.
        restored: submissions that were withdrawn, and are no more.

    Raises:
        TampError: where a server or worker is at work, or a submission to be restored is not withdrawn.
    """
    contest = load_contest(rules_file(data))
    with alone(data):
        store = open_store(data, database)
        require_packages(store, data, every=True)
        restore(store, restored)
        found = refresh(store, contest, everything=everything)
        for trial in found.queued:
            films.forget(data, trial)
    return found


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens; at port 0, at one that is free.

    Raises:
        TampError: where nobody can listen there.
    """
    try:
        return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
    except (OSError, OverflowError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise TampError(f"cannot listen at {host}, port {port}: {why}; choose another --port or --host") from None


def serve(
    data: Path,
    database: str | None,
    listening: socket.socket,
    workers: Sequence[Sequence[str]],
    sandbox: Sandbox,
    ready: Callable[[], None] = lambda: None,
) -> None:
    """Serve pages and API until interrupted.

    Args:
        data: the folder with the rules, and for everything else.
        database: URL; SQLite in `data` where it is None.
        listening: where requests come in.
        workers: the command of each worker process.
        sandbox: where they run solutions.
        ready: called when nothing is left to be refused.

    Raises:
        TampError: where rules, tasks or database cannot be used, or its workers could run no solution.
    """
    import uvicorn

    from tamp.contest.service.web.app import make_app
    from tamp.contest.service.web.prompt import PromptProtocol

    rules = rules_file(data)
    with listening, at_work(data), scratch_folder(data) as folder:
        contest, store = load_contest(rules), open_store(data, database)
        require_packages(store, data)
        app = make_app(store, settled(store, contest), data)
        tempfile.tempdir = str(folder.resolve())
        if workers:
            require_doable(contest.entries["contest"][0].task, contest.rules, sandbox)
        settings = uvicorn.Config(app, log_level="warning", server_header=False, http=PromptProtocol)
        ready()
        with _kept(workers), suppress(KeyboardInterrupt):
            uvicorn.Server(settings).run([listening])


@contextmanager
def _kept(workers: Sequence[Sequence[str]]) -> Iterator[None]:
    """Keep workers running, each started by its command, as long as the block runs."""
    ending = threading.Event()
    keepers = [threading.Thread(target=_keep, args=(command, ending), daemon=True) for command in workers]
    for keeper in keepers:
        keeper.start()
    try:
        yield
    finally:
        ending.set()
        for keeper in keepers:
            keeper.join(10.0)


def _keep(command: Sequence[str], ending: threading.Event) -> None:
    """Run a worker, and another one after it: later and later where they fail at once, which is said once."""
    pause = AGAIN_S
    while not ending.is_set():
        began = time.monotonic()
        status, how = _ended(command, ending)
        if ending.is_set():
            return
        if status <= 0 or time.monotonic() - began > LONGEST_PAUSE_S:  # killed, perhaps, but it could work
            pause = AGAIN_S
        if pause == AGAIN_S:
            LOG.warning("%s; another one is started, %g s later at most where that goes on", how, LONGEST_PAUSE_S)
        ending.wait(pause)
        pause = min(2 * pause, LONGEST_PAUSE_S)


def _ended(command: Sequence[str], ending: threading.Event) -> tuple[int, str]:
    """Run a worker until it has ended, or is to: its exit status, negative for a signal, and that in words."""
    try:
        process = subprocess.Popen(command)
    except OSError as error:  # the machine has no process or memory to spare now
        return 1, f"a worker could not be started: {error.strerror}"
    while process.poll() is None and not ending.wait(LOOK_S):
        pass
    if process.poll() is None:
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(5.0)
        process.kill()
    status = process.wait()
    return status, f"a worker ended with status {status}"


def worker_command(data: Path, database: str | None, options: Sequence[str]) -> list[str]:
    """The command that starts a worker."""
    url = [] if database is None else ["--database", database]
    return [
        sys.executable,
        "-m",
        "tamp",
        "contest",
        "work",
        "--data",
        str(data),
        *url,
        "--parent",
        str(os.getpid()),
        *options,
    ]
