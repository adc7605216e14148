"""Batches: what goes wrong in one job stays there, and every result is written exactly once.

All batches of a process fork from the server that the first of them started: it is the usual one here too.
"""

from __future__ import annotations

import json
import multiprocessing.util
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import forkserver
from pathlib import Path

import pytest

from tamp.batch import RESULTS, Batch
from tamp.batch.pool import Job, run_jobs
from tamp.batch.processes import available
from tamp.results import read_results
from tests.batch.batches import WORK, run_batch, tasks_named

needs_proc = pytest.mark.skipif(not available(), reason="this system has no /proc")


def _gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def test_a_job_that_goes_wrong_costs_only_itself() -> None:
    results = run_batch("ok_1", "crash", "exit", "raise", "kill", "ok_2", workers=2, seeds=(0, 7))
    assert len(results) == 12
    assert {name: results[name, 7].status for name in ("ok_1", "crash", "exit", "raise", "kill", "ok_2")} == {
        "ok_1": "solved", "crash": "error", "exit": "error", "raise": "error", "kill": "error", "ok_2": "solved",
    }  # fmt: skip
    assert results["crash", 0].message == "the worker was ended by SIGABRT"
    assert results["kill", 0].message == "the worker was ended by SIGKILL"
    assert "exit status 3" in results["exit", 0].message
    assert results["raise", 0].message == "ValueError: a bug in two lines"


RAISING = """
import sys
from pathlib import Path
from tamp.batch import Batch
from tamp.task import Task

if __name__ == "__main__":
    for result in Batch([Task(sys.argv[1], (), path=Path("t"))], work="tests.batch.toys:work", preload=()).run():
        print(result.message)
"""


@pytest.mark.parametrize(
    ("kind", "message", "told"),
    [("raise", "ValueError: a bug in two lines\n", True), ("refuse", "no such simulator\n", False)],
)
def test_a_bug_in_a_job_shows_its_traceback_and_what_is_refused_does_not(
    tmp_path: Path, kind: str, message: str, told: bool
) -> None:
    """In a process of its own: workers write to the standard error that the first batch of a process had."""
    (tmp_path / "batch.py").write_text(RAISING, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, str(tmp_path / "batch.py"), kind]
    run = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    assert run.stdout == message
    assert ("Traceback" in run.stderr and "a bug" in run.stderr) == told, run.stderr


UNHEARD = """
from multiprocessing import Pipe
from tamp.batch.worker import run_job

def leave():
    ours.close()  # as the kernel does where the batch is killed
    return {}

if __name__ == "__main__":
    ours, theirs = Pipe(duplex=False)
    run_job(theirs, "__main__:leave", {}, 0)
"""


def test_a_worker_whose_batch_is_gone_ends_without_a_word(tmp_path: Path) -> None:
    (tmp_path / "unheard.py").write_text(UNHEARD, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, str(tmp_path / "unheard.py")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("", "")


@needs_proc
def test_a_job_that_hangs_ends_with_all_it_started(tmp_path: Path) -> None:
    pids = tmp_path / "pids"
    results = run_batch("hang", "ok", options={"pids": str(pids)}, time_limit_s=8.0)
    assert results["hang", 0].status == "timeout"
    assert "ended from outside after 8 s" in results["hang", 0].message
    assert results["ok", 0].solved
    for pid in pids.read_text(encoding="utf-8").split():
        while not _gone(int(pid)):  # killed, but the system takes its time
            time.sleep(0.05)


def test_a_job_says_itself_by_when_it_must_have_ended() -> None:
    results = run_batch("late", "ok", time_limit_s=60.0)
    assert results["late", 0].status == "timeout"
    assert "planning did not end with its limit" in results["late", 0].message
    assert results["ok", 0].solved


def test_a_job_whose_fork_server_dies_is_run_again(tmp_path: Path) -> None:
    once = tmp_path / "once"
    results = run_batch("orphan", "ok", options={"once": str(once)})
    assert {r.status for r in results.values()} == {"solved"}
    assert once.is_file()


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_who_interrupts_while_a_worker_is_asked_for_leaves_no_half_request_to_the_fork_server(
    sign: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[bool] = []
    send = forkserver.reduction.sendfds  # type: ignore[attr-defined]

    def interrupted(*arguments: object) -> None:
        os.kill(os.getpid(), sign)
        time.sleep(0.05)  # where it is not held back, it comes before what the server waits for
        send(*arguments)
        asked.append(True)

    def end(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(forkserver.reduction, "sendfds", interrupted)  # type: ignore[attr-defined]
    before = signal.signal(sign, end)
    try:
        with pytest.raises(KeyboardInterrupt):
            next(run_jobs([Job("job", {"name": "slow", "path": "t", "seed": 0, "sleep": 60.0})], WORK))
    finally:
        signal.signal(sign, before)
    assert asked


@needs_proc
def test_a_job_that_eats_memory_is_ended() -> None:
    results = run_batch("eat", "ok", memory_limit=400 << 20, time_limit_s=60.0)
    assert results["eat", 0].status == "error"
    assert "GiB of memory" in results["eat", 0].message
    assert results["ok", 0].solved


SCRIPT = """
import signal
import sys
from pathlib import Path
from tamp.batch import Batch
from tamp.task import Task

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs begin with it ignored
    tasks = [Task(f"slow_{i}", (), path=Path("t")) for i in range(12)]
    options = {"ran": sys.argv[2], "sleep": float(sys.argv[3])}
    for result in Batch(tasks, options=options, output=Path(sys.argv[1]), work="tests.batch.toys:work", preload=(),
                        workers=2, resume=True).run():
        print(result.task, flush=True)
"""


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGKILL])
def test_a_batch_that_is_ended_leaves_a_file_that_can_be_resumed(tmp_path: Path, sign: signal.Signals) -> None:
    (tmp_path / "batch.py").write_text(SCRIPT, encoding="utf-8")
    root = str(Path(__file__).parents[2])
    slow, fast = (
        [sys.executable, str(tmp_path / "batch.py"), str(tmp_path / "out"), str(tmp_path / "ran"), sleep]
        for sleep in ("2.0", "0.1")
    )
    environment = {**os.environ, "PYTHONPATH": root}
    with subprocess.Popen(slow, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.stdout.readline()
        process.send_signal(sign)
        process.wait()
    lines = (tmp_path / "out" / RESULTS).read_text(encoding="utf-8").splitlines()
    assert 2 <= len(lines) < 12
    assert all(json.loads(line)["status"] == "solved" for line in lines)
    subprocess.run(fast, env=environment, check=True, capture_output=True)
    names = [r.task for r in read_results(tmp_path / "out" / RESULTS)]
    assert sorted(names) == sorted(f"slow_{i}" for i in range(12))


def test_an_interrupt_while_a_process_is_tidied_up_after_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Python drops what is raised there, and the batch went on."""
    close, interrupts = multiprocessing.util.close_fds, [signal.SIGINT]

    def close_fds(*fds: int) -> None:
        if interrupts:
            signal.raise_signal(interrupts.pop())
        close(*fds)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    jobs = [Job(name, {"name": name, "path": "", "seed": 0}) for name in ("ok_1", "ok_2")]
    monkeypatch.setattr(multiprocessing.util, "close_fds", close_fds)
    try:
        with pytest.raises(KeyboardInterrupt):
            list(run_jobs(jobs, WORK))
    finally:
        signal.signal(signal.SIGINT, before)
    assert not interrupts


@needs_proc
def test_under_a_killer_every_task_has_one_result(tmp_path: Path) -> None:
    """Worker after worker is killed at random moments; nothing is lost and nothing counted twice."""
    names = [f"slow_{i}" for i in range(20)]
    batch = Batch(tasks_named(*names), options={"sleep": 0.2}, output=tmp_path, work=WORK, workers=2)
    seen: list[str] = []
    ended = threading.Event()
    with ThreadPoolExecutor(1) as pool:
        kills = pool.submit(_kill_workers, ended)
        try:
            seen.extend(result.task for result in batch.run())
        finally:
            ended.set()
    assert kills.result() >= 1
    assert sorted(seen) == sorted(names)
    assert sorted(r.task for r in read_results(tmp_path / RESULTS)) == sorted(names)


def _kill_workers(ended: threading.Event) -> int:
    """Kill a worker five times a second; how many were killed."""
    killed = 0
    while not ended.wait(0.2):
        killed += _kill_a_worker()
    return killed


def _kill_a_worker() -> int:
    """Kill one process that works for this one, found as a session leader below it."""
    from tamp.batch.processes import tree

    for pid in sorted(tree(os.getpid()), reverse=True):
        try:
            leads = os.getsid(pid) == pid and pid != os.getsid(0)
        except ProcessLookupError:
            continue
        if leads:
            os.kill(pid, signal.SIGKILL)
            return 1
    return 0
