"""The leaderboard reads what is new, and ranks as if it had read all."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from fastapi.testclient import TestClient
from sqlalchemy import update

from tamp.cli import main
from tamp.contest.service.board import Board
from tamp.contest.service.queue import refresh
from tamp.contest.service.store import TRIALS
from tamp.contest.service.web.app import make_app
from tests.contest.service.served import CODE, Service


def test_what_is_exported_is_ranked_by_the_command_line_as_on_the_leaderboard(
    service: Service, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of single objects it says something when hidden tasks are revealed."""
    for team, error in ((service.ours, 0.09), (service.theirs, 0.05)):
        service.hand_in(team)
        service.evaluate(error)
    for one in service.get("/api/export", service.ours).json()["submissions"]:
        folder = tmp_path / ("ours" if one["team"] == "ours" else "theirs")
        folder.mkdir()
        (folder / "results.jsonl").write_text("".join(f"{json.dumps(result)}\n" for result in one["results"]))
    command = ["score", "--leaderboard", str(tmp_path / "ours"), str(tmp_path / "theirs"), "--best-of", "2"]
    assert main([*command, "--json", "-"]) == 0
    ranked = [(place["solution"], place["mean"]["error_m"]) for place in json.loads(capsys.readouterr().out)]
    shown = service.get("/api/leaderboard").json()["places"]
    assert ranked == [("theirs", shown[0]["mean"]["error_m"]), ("ours", shown[1]["mean"]["error_m"])]
    revealed = replace(service.contest, rules=replace(service.contest.rules, reveal=True))
    client = TestClient(make_app(service.store, revealed, service.data))
    assert "red_secret" in client.get("/api/export", headers={"Authorization": f"Bearer {service.ours}"}).text


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
