"""The leaderboard reads what is new, and ranks as if it had read all."""

from __future__ import annotations

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from sqlalchemy import update

from tamp.contest.service.board import Board
from tamp.contest.service.queue import refresh
from tamp.contest.service.store import TRIALS
from tests.contest.service.served import CODE, Service


def test_a_submission_that_is_done_is_read_once(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run that ended had all results of all submissions read again."""
    read: list[str] = []
    results = Board.results
    monkeypatch.setattr(Board, "results", lambda self, number: read.append(number) or results(self, number))
    board, numbers = Board(service.store, service.contest), []
    for count, (team, error) in enumerate(
        [(service.ours, 0.09), (service.theirs, 0.05), (service.ours, 0.04), (service.ours, 0.07)]
    ):
        kind = "trial" if count == 3 else "contest"
        numbers.append(service.hand_in(team, CODE + b"#%d" % count, kind=kind).json()["id"])
        assert board.places("contest") == Board(service.store, service.contest).places("contest")
        service.evaluate(error)
        places = board.places("contest")
        assert places == Board(service.store, service.contest).places("contest")
    assert [(p.standing.rank, p.standing.solution[:4], p.submission, p.submissions) for p in places] == [
        (1, "ours", numbers[2], 2),
        (2, "<scr", numbers[1], 1),
    ]
    read.clear()
    assert board.places("contest") == places and read == []
    with service.store.change() as connection:
        connection.execute(update(TRIALS).where(TRIALS.c.submission == numbers[2]).values(result=None))
    refresh(service.store, service.contest)
    assert [p.submission for p in board.places("contest")] == [numbers[1], numbers[0]] and read == []
    service.evaluate(0.2)
    assert [p.submission for p in board.places("contest")] == [numbers[1], numbers[0]] and read == [numbers[2]]
