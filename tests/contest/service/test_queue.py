"""The queue and its workers: each run is done once, in turn, and killed workers leave nothing."""

from __future__ import annotations

import errno
import logging
import os
import re
import sqlite3
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from sqlalchemy import select, update

from tamp.contest.evaluation.trial import Trial
from tamp.contest.sandbox.choice import choose
from tamp.contest.sandbox.isolation import Ending, Room
from tamp.contest.sandbox.plain import Plain
from tamp.contest.service import queue
from tamp.contest.service import worker as working
from tamp.contest.service.contest import load_contest
from tamp.contest.service.scratch import scratch_folder
from tamp.contest.service.store import TRIALS, Store
from tamp.contest.service.worker import MOST_CLAIMS, Worker
from tamp.errors import TampError
from tamp.results import Result
from tests.contest.service.served import CODE, Service


def test_a_run_that_ends_its_workers_is_given_up(service: Service) -> None:
    service.hand_in(service.ours)
    with service.store.change() as connection:
        connection.execute(update(TRIALS).values(claims=MOST_CLAIMS))
    worker = Worker(service.store, service.contest, service.data, choose(insecure=True))
    while (doomed := queue.claim(service.store)) is not None:
        worker.do(doomed)
    with service.store.look() as connection:
        rows = connection.execute(select(TRIALS.c.state, TRIALS.c.log)).all()
    assert len(rows) == 4 and {tuple(row) for row in rows} == {("done", "8 workers ended while they did this run")}
    assert service.get("/").status_code == 200
    assert len(queue.refresh(service.store, service.contest).queued) == 4  # what ended them may be mended
    held = queue.claim(service.store)
    assert held is not None and held.claims == 1


def test_what_the_machine_lacks_costs_a_run_nothing(
    service: Service, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """It waits its turn again however often that happens, others have theirs meanwhile, and the log has a line."""
    service.hand_in(service.ours)
    monkeypatch.setattr(working, "IDLE_S", 0.0)
    monkeypatch.setattr(queue, "PUT_OFF_S", 0.0)
    worker = Worker(service.store, service.contest, service.data, _NoSandbox())
    shortages = [OSError(number, os.strerror(number)) for number in (errno.ENOSPC, errno.EMFILE, errno.EAGAIN)]
    unwatched = TampError("a solution could not be watched")
    unwatched.__cause__ = shortages[1]
    causes = [None, *shortages, unwatched]
    for cause in causes * MOST_CLAIMS:
        with monkeypatch.context() as patched:
            if cause is not None:
                patched.setattr(working, "unpack", _raise(cause))
            held = queue.claim(service.store)
            assert held is not None and held.claims == 1
            worker.do(held)
    monkeypatch.setattr(queue, "PUT_OFF_S", 1000.0)
    assert len({_put_off(worker, service) for _ in range(4)}) == 4
    assert queue.claim(service.store) is None
    errors = [record for record in caplog.records if record.levelno >= logging.ERROR]
    assert len(errors) == len(causes) * MOST_CLAIMS + 4
    assert all(record.exc_info is None and "could not be begun" in record.getMessage() for record in errors)
    assert "status 3 before run() returned: no namespaces today" in errors[0].getMessage()


def test_runs_that_cannot_be_begun_are_tried_later_and_later_and_told(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They were tried each minute for ever, and kept who waits for the end of all from ending."""
    now, pauses = [1e9], []
    monkeypatch.setattr("tamp.contest.service.queue.time.time", lambda: now[0])
    monkeypatch.setattr(working, "unpack", _raise(OSError(errno.ENOSPC, "no room for a.secret")))
    number = service.hand_in(service.ours).json()["id"]
    held = queue.claim(service.store)
    for _ in range(6):
        assert held is not None
        pauses.append(queue.put_off(service.store, held, "no room"))
        now[0] += pauses[-1] + 1
        held = next(h for h in iter(lambda: queue.claim(service.store), None) if h.trial == held.trial)
    assert pauses == [60, 120, 240, 480, 600, 600]
    now[0] += 100
    monkeypatch.setattr(working.time, "sleep", lambda s: now.__setitem__(0, now[0] + s))
    monkeypatch.setattr(working, "IDLE_S", 30.0)
    Worker(service.store, service.contest, service.data, Plain()).run(until_empty=True)  # ends
    told = queue.put_off_now(service.store)
    assert told is not None and (told.runs, told.since) == (4, 1e9) and "a.secret" in told.cause
    assert str(told).startswith("4 runs put off since 09 Sep 2001 01:46 UTC: ")
    for page in (service.get("/").text, service.get(f"/submissions/{number}").text):
        assert "4 runs could not be begun" in page and "a.secret" not in page
    assert service.get(f"/api/submissions/{number}").json()["put_off"] == 4
    now[0] += 1000
    assert service.evaluate() == 4 and queue.put_off_now(service.store) is None
    assert "could not be begun" not in service.get("/").text


def test_what_is_put_off_is_at_once_in_turn_again_after_again(service: Service) -> None:
    service.hand_in(service.ours)
    while (held := queue.claim(service.store)) is not None:
        queue.put_off(service.store, held, "no room")
    assert len(queue.refresh(service.store, service.contest).queued) == 4
    assert queue.put_off_now(service.store) is None and queue.claim(service.store) is not None


def test_rules_by_which_nothing_can_be_run_are_refused_at_the_start(
    service: Service, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from tamp.cli import main

    monkeypatch.setattr(tempfile, "tempdir", tempfile.gettempdir())  # which the commands change for their process
    monkeypatch.setattr("uvicorn.Server.run", _raise(AssertionError("it serves")))
    with (service.data / "contest.yaml").open("a") as file:
        file.write("limits: {memory_mb: 8}\n")
    why = "contest.yaml: no solution can be run, .* ends by (start: the process ended with status|memory: used more)"
    for action in (["serve", "--port", "1"], ["work", "--until-empty"]):
        assert main(["contest", *action, "--data", str(service.data), "--no-isolation"]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1 and re.search(why, said), said


class _NoSandbox(Plain):
    """One that worked when the service began, and does not any more."""

    def command(self, room: Room, command: Sequence[str]) -> list[str]:
        return ["/bin/sh", "-c", "echo no namespaces today; exit 3"]


def _raise(error: Exception) -> Callable[..., None]:
    def fail(*_: object) -> None:
        raise error

    return fail


def _put_off(worker: Worker, service: Service) -> int:
    held = queue.claim(service.store)
    assert held is not None
    worker.do(held)
    return held.trial


def test_a_lease_that_ended_is_given_on_and_its_holder_records_nothing(service: Service) -> None:
    service.hand_in(service.ours)
    late = queue.claim(service.store)
    assert late is not None and queue.renew(service.store, late)
    with service.store.change() as connection:
        connection.execute(update(TRIALS).where(TRIALS.c.id == late.trial).values(until=time.time() - 1))
    held = [queue.claim(service.store) for _ in range(4)]
    again = next(h for h in held if h is not None and h.trial == late.trial)
    assert queue.claim(service.store) is None
    assert not queue.renew(service.store, late)
    assert not queue.finish(service.store, late, "late", "")
    assert queue.finish(service.store, again, "in time", "")
    assert not queue.finish(service.store, again, "twice", "")
    with service.store.look() as connection:
        row = connection.execute(select(TRIALS).where(TRIALS.c.id == late.trial)).one()
    assert (row.result, row.evaluations, row.claims, row.state) == ("in time", 1, 2, "done")


def test_a_lease_of_before_the_clock_was_put_back_is_given_on(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its holder may have ended: the run waited until the clock came to where it had been."""
    service.hand_in(service.ours)
    lost, *_ = [queue.claim(service.store) for _ in range(4)]
    clock = time.time
    monkeypatch.setattr(time, "time", lambda: clock() - 1800)
    assert queue.claim(service.store) is None, "another worker's lease may be so long"
    monkeypatch.setattr(time, "time", lambda: clock() - 86400)
    again = queue.claim(service.store)
    assert lost is not None and again is not None and again.trial == lost.trial
    assert not queue.finish(service.store, lost, "late", "") and queue.finish(service.store, again, "in time", "")


def test_teams_take_turns(service: Service) -> None:
    first, second = (service.hand_in(token).json()["id"] for token in (service.ours, service.theirs))
    held = [queue.claim(service.store) for _ in range(4)]
    assert [h.submission for h in held if h is not None] == [first, second, first, second]
    mine = [first, *(service.hand_in(service.ours, CODE + b"#%d" % n, kind="trial").json()["id"] for n in range(5))]
    held = [queue.claim(service.store) for _ in range(12)]
    turns = [h.submission in mine for h in held if h is not None]
    assert turns == [True, False] * 2 + [True] * 8, "who hands in much bars nobody"


def test_tables_are_made_by_who_begins_first(tmp_path: Path) -> None:
    """As where a server and workers begin at once after an upgrade: all but one said that the database is locked."""
    together = threading.Barrier(6)

    def begin(_: int) -> None:
        together.wait()
        Store(f"sqlite:///{tmp_path / 'contest.db'}").close()

    with ThreadPoolExecutor(6) as pool:
        list(pool.map(begin, range(6)))


def test_who_begins_while_another_makes_a_new_file_waits_for_that(tmp_path: Path) -> None:
    """SQLite itself does not wait there: of servers and workers that began at once one in a hundred was refused."""
    other = sqlite3.connect(tmp_path / "contest.db", isolation_level=None, check_same_thread=False)
    other.execute("CREATE TABLE something (x)")
    other.execute("BEGIN IMMEDIATE")
    done = threading.Timer(0.2, other.close)
    done.start()
    Store(f"sqlite:///{tmp_path / 'contest.db'}").close()
    done.join()


def test_the_database_and_the_rules_are_refused_in_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(TampError, match="the database cannot be used"):
        Store("no url")
    (tmp_path / "contest.yaml").write_text("name: empty\n")
    with pytest.raises(TampError, match="at least one task file"):
        load_contest(tmp_path / "contest.yaml")


def test_where_nothing_may_be_printed_endings_are_not_in_the_solutions_words(service: Service) -> None:
    words = Ending("raised", "RuntimeError: the red box goes to 0, -0.1")
    message = f"{words.reason}: {words.message}"
    trial = Trial(Result("hidden_a_secret", 0, "failed", message=message), words, b"the red box", ())
    service.hand_in(service.ours)
    held = queue.claim(service.store)
    assert held is not None
    for most, said, log in ((4, message, "the red box"), (0, "raised", "")):
        rules = replace(service.contest.rules, contest_log_kb=most)
        worker = Worker(service.store, replace(service.contest, rules=rules), service.data, Plain())
        assert (worker._message(held, trial), worker._log(held, trial)) == (said, log)


def test_what_killed_workers_left_is_removed_and_what_others_use_is_not(tmp_path: Path) -> None:
    left = tmp_path / "scratch" / "left"
    left.mkdir(parents=True)
    (left / "package.py").touch()
    with scratch_folder(tmp_path) as one, scratch_folder(tmp_path) as other:
        assert one != other and one.is_dir() and not left.exists()
    assert not one.exists() and not other.exists()


def test_a_contest_task_is_no_trial_task_that_anybody_gets(service: Service) -> None:
    rules = service.data / "contest.yaml"
    rules.write_text("contest: ['*_a.yaml']\ntrial: ['hidden_*.yaml']\n")
    with pytest.raises(TampError, match=r"hidden_a.yaml is in both sets; whoever asks gets the trial tasks"):
        load_contest(rules)
