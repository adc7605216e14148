"""A database out of reach: one sentence for who asks, one line in the log, and nothing is lost."""

from __future__ import annotations

import logging
import sqlite3
import threading
from collections.abc import Callable

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from sqlalchemy import Engine
from sqlalchemy.exc import DatabaseError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as NoConnectionError

from tamp.cli import main
from tamp.contest.sandbox.plain import Plain
from tamp.contest.service import serve
from tamp.contest.service import worker as working
from tamp.contest.service.worker import Worker
from tests.contest.service.served import Service

SENTENCE = "the database cannot be reached; try again in a moment"
CAUSES = (
    OperationalError("SELECT 1", {}, sqlite3.OperationalError("connection refused\nIs the server running?")),
    InterfaceError("SELECT 1", {}, sqlite3.InterfaceError("the connection is closed")),
    NoConnectionError("QueuePool limit of size 5 overflow 10 reached"),
)
DAMAGED = DatabaseError("SELECT 1", {}, sqlite3.DatabaseError("database disk image is malformed"))
PAGES = ("/", "/team", "/submissions/1", "/nowhere", "/films/1.gif")


@pytest.fixture
def fail(service: Service, monkeypatch: pytest.MonkeyPatch) -> Callable[[Exception], None]:
    """Let every connection to the service's database fail."""

    def fail(error: Exception) -> None:
        def connect(_: Engine) -> None:
            raise error

        monkeypatch.setattr(Engine, "connect", connect)

    return fail


@pytest.mark.parametrize("cause", [*CAUSES, DAMAGED], ids=lambda cause: type(cause).__name__)
def test_pages_and_api_say_it_in_a_sentence(
    service: Service, fail: Callable[[Exception], None], caplog: pytest.LogCaptureFixture, cause: Exception
) -> None:
    fail(cause)
    answers = [service.get(path, service.ours) for path in ("/api/submissions", "/api/leaderboard")]
    answers.append(service.hand_in(service.ours))
    assert [(answer.status_code, answer.json()) for answer in answers] == [(503, {"detail": SENTENCE})] * 3
    browser = {"Accept": "text/html", "Cookie": f"tamp_contest_token={service.ours}"}
    for path in PAGES:
        page = service.client.get(path, headers=browser)
        assert (page.status_code, page.headers["Content-Type"]) == (503, "text/html; charset=utf-8"), path
        assert SENTENCE in page.text and "Content-Security-Policy" in page.headers
    records = [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert len(records) == len(answers) + len(PAGES)
    assert all(record.exc_info is None and "\n" not in record.getMessage() for record in records)


def test_commands_say_that_a_file_is_damaged_and_what_to_do(
    service: Service, capsys: pytest.CaptureFixture[str]
) -> None:
    service.hand_in(service.ours)
    with sqlite3.connect(service.data / "contest.db") as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    service.store.close()
    with (service.data / "contest.db").open("r+b") as file:
        size = file.seek(0, 2)
        file.seek(4096)  # its first page, which says what tables there are, stays
        file.write(b"\xff" * (size - 4096))
    for command in (["again"], ["team", "Others"], ["work", "--until-empty"]):
        assert main(["contest", *command, "--data", str(service.data)]) == 2
        said = capsys.readouterr().err
        assert "the database is damaged (database disk image is malformed); stop the service, and put a backup" in said


def test_a_locked_sqlite_is_out_of_reach_and_takes_the_upload_later(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tamp.contest.service.store.BUSY_S", 0.05)
    service.store.close()  # new connections wait as long as that
    other = sqlite3.connect(service.data / "contest.db", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    answer = service.hand_in(service.ours)
    other.close()
    assert (answer.status_code, answer.json()["detail"]) == (503, SENTENCE)
    assert service.hand_in(service.ours).status_code == 201


def test_a_full_disk_is_no_database_out_of_reach(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OperationalError("INSERT", {}, sqlite3.OperationalError("database or disk is full"))

    monkeypatch.setattr("tamp.contest.service.submissions._insert", full)
    assert service.hand_in(service.ours).status_code == 507


def test_idle_workers_wait_for_the_database_and_say_so_once(
    service: Service, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    causes = [cause for cause in CAUSES for _ in range(5)]

    def make_one(*_: object) -> bool:
        if causes:
            raise causes.pop()
        return False

    monkeypatch.setattr(working, "IDLE_S", 0.0)
    monkeypatch.setattr(working.films, "make_one", make_one)
    Worker(service.store, service.contest, service.data, Plain()).run(until_empty=True)
    assert not causes
    said = [record.getMessage().partition(",")[0] for record in caplog.records]
    assert said == ["the database does not answer"] * len(CAUSES) + ["the database answers again"]


@pytest.mark.parametrize(
    ("command", "pauses", "said"),
    [
        (["/bin/sh", "-c", "exit 2"], [1, 2, 4, 8, 16, 32, 60, 60], ["a worker ended with status 2"]),
        (
            ["/nowhere/python"],
            [1, 2, 4, 8, 16, 32, 60, 60],
            ["a worker could not be started: No such file or directory"],
        ),
        (["/bin/sh", "-c", "kill -9 $$"], [1] * 8, ["a worker ended with status -9"] * 8),
    ],
    ids=["fails", "cannot begin", "is killed"],
)
def test_workers_that_fail_at_once_are_started_later_and_later_and_that_is_said_once(
    caplog: pytest.LogCaptureFixture, command: list[str], pauses: list[int], said: list[str]
) -> None:
    waited: list[float | None] = []

    class Ending(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            if timeout == serve.LOOK_S:
                return super().wait(0.01)
            waited.append(timeout)
            if len(waited) == len(pauses):
                self.set()
            return self.is_set()

    serve._keep(command, Ending())
    assert waited == pauses
    assert [record.getMessage().partition(";")[0] for record in caplog.records] == said
