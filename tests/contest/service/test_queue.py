"""The queue and its workers: each run is done once, in turn, and killed workers leave nothing."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from sqlalchemy import select, update

from tamp.contest.evaluation.trial import Trial
from tamp.contest.sandbox.choice import choose
from tamp.contest.sandbox.isolation import Ending
from tamp.contest.sandbox.plain import Plain
from tamp.contest.service import queue
from tamp.contest.service.contest import load_contest
from tamp.contest.service.scratch import scratch_folder
from tamp.contest.service.store import TRIALS, Store
from tamp.contest.service.worker import MOST_CLAIMS, Worker
from tamp.errors import TampError
from tamp.results import Result
from tests.contest.service.served import Service


def test_a_run_that_ends_its_workers_is_given_up(service: Service) -> None:
    service.hand_in(service.ours)
    with service.store.change() as connection:
        connection.execute(update(TRIALS).values(claims=MOST_CLAIMS))
    worker = Worker(service.store, service.contest, service.data, choose(insecure=True))
    while (held := queue.claim(service.store)) is not None:
        worker.do(held)
    with service.store.look() as connection:
        rows = connection.execute(select(TRIALS.c.state, TRIALS.c.log)).all()
    assert len(rows) == 4 and {tuple(row) for row in rows} == {("done", "8 workers ended while they did this run")}
    assert service.get("/").status_code == 200


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


def test_teams_take_turns(service: Service) -> None:
    first, second = (service.hand_in(token).json()["id"] for token in (service.ours, service.theirs))
    held = [queue.claim(service.store) for _ in range(4)]
    assert [h.submission for h in held if h is not None] == [first, second, first, second]


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
