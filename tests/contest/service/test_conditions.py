"""Rules and tasks that change while there are submissions: nothing is ranked by runs on another set."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from fastapi.testclient import TestClient

from tamp.cli import main
from tamp.contest.service import queue
from tamp.contest.service.contest import load_contest
from tamp.contest.service.films import film_path
from tamp.contest.service.queue import settled
from tamp.contest.service.scratch import at_work
from tamp.contest.service.serve import again
from tamp.contest.service.submissions import require_packages
from tamp.contest.service.web.app import make_app
from tamp.errors import TampError
from tests.contest.service.served import CODE, TASK, Service


def _load(service: Service) -> None:
    """Begin anew with what the folder says."""
    service.contest = settled(service.store, load_contest(service.data / "contest.yaml"))
    app = make_app(service.store, service.contest, service.data)
    service.client = TestClient(app, raise_server_exceptions=False)


def _renew(service: Service) -> tuple[int, int]:
    """How many runs are queued, and how many put aside."""
    found = again(service.data, None, everything=False)
    _load(service)
    return len(found.queued), found.aside


def _change(service: Service, old: str, new: str) -> None:
    rules = service.data / "contest.yaml"
    rules.write_text(rules.read_text().replace(old, new))


def _place(service: Service) -> dict[str, Any]:
    place: dict[str, Any]
    (place,) = service.get("/api/leaderboard").json()["places"]
    return place


def test_a_hidden_task_keeps_its_number_where_another_one_is_withdrawn(service: Service) -> None:
    _load(service)
    number = service.hand_in(service.ours).json()["id"]
    assert service.evaluate(0.05) == 4
    (service.data / "hidden_a.yaml").rename(service.data / "withdrawn.yaml")
    with pytest.raises(TampError, match=r"contest tasks 001 are gone; change it back, or .*tamp contest again --data"):
        _load(service)
    assert _renew(service) == (0, 2)
    assert [(e.label, e.task.name) for e in service.contest.entries["contest"]] == [("002", "hidden_b_secret")]
    assert list(_place(service)["tasks"]) == ["002"]
    page = service.get(f"/submissions/{number}", service.ours).text
    assert "2 of 2 runs" in page and "001" not in page
    (service.data / "hidden_0.yaml").write_text(TASK.format(name="hidden_0_secret"))  # sorts before the other one
    (service.data / "withdrawn.yaml").rename(service.data / "hidden_z.yaml")
    assert _renew(service) == (2, 0)
    assert [e.task.name[:8] for e in service.contest.entries["contest"]] == ["hidden_a", "hidden_b", "hidden_0"]
    assert service.get("/api/leaderboard").json()["places"] == []  # it is not on the board by two tasks of three
    assert service.evaluate(0.08) == 2
    assert _place(service)["tasks"] == pytest.approx({"001": 0.05, "002": 0.05, "003": 0.08})


def test_more_runs_are_added_and_fewer_put_aside(service: Service) -> None:
    _load(service)
    service.hand_in(service.ours)
    service.hand_in(service.theirs, kind="trial")
    service.evaluate()
    _change(service, "runs: 2", "runs: 3")
    with pytest.raises(TampError, match="runs was 2 and is 3"):
        _load(service)
    assert _renew(service) == (3, 0)
    assert service.evaluate() == 3
    _change(service, "runs: 3", "runs: 1")
    assert _renew(service) == (0, 6)
    assert service.evaluate() == 0
    assert _place(service)["attempted"] == 2


@pytest.mark.parametrize("rule", ["execution_s: 300", "seed: 7", "renderer: software"])
def test_what_was_run_under_other_rules_is_run_again_also_where_it_comes_back_later(
    service: Service, rule: str
) -> None:
    _load(service)
    number = service.hand_in(service.ours).json()["id"]
    service.evaluate(0.05)
    (run, *_) = service.get(f"/api/submissions/{number}", service.ours).json()["runs"]
    film = film_path(service.data, run["trial"])
    film.parent.mkdir()
    film.write_bytes(b"GIF89a")
    hidden = service.data / "hidden_a.yaml"
    hidden.rename(service.data / "away")
    _renew(service)
    _change(service, "runs: 2", f"runs: 2\n{rule}")
    with pytest.raises(TampError, match=f"{rule.partition(':')[0]} has changed"):
        _load(service)
    assert _renew(service) == (2, 2)
    service.evaluate(0.07)
    (service.data / "away").rename(hidden)
    assert _renew(service) == (2, 0)
    assert not film.exists()
    service.evaluate(0.09)
    assert _place(service)["tasks"] == pytest.approx({"001": 0.09, "002": 0.07})


def test_nothing_is_held_against_new_rules_while_somebody_works_by_the_old_ones(service: Service) -> None:
    _load(service)
    service.hand_in(service.ours)
    told = "is at work, by the rules as they were when it began; stop all of them"
    with at_work(service.data), at_work(service.data), pytest.raises(TampError, match=told):
        again(service.data, None, everything=True)
    assert again(service.data, None, everything=True).queued


def test_how_it_is_counted_and_what_nothing_was_handed_in_for_may_change(service: Service) -> None:
    _load(service)
    _change(service, "runs: 2", "runs: 1")
    _load(service)
    service.hand_in(service.ours)
    assert service.evaluate() == 2
    _change(service, "runs: 1", "runs: 1\nbest_of_runs: mean\nreveal: true\nlimits: {wall_s: 60}")
    _load(service)


def test_every_run_is_done_anew_where_that_is_asked_for(service: Service) -> None:
    _load(service)
    service.hand_in(service.ours, CODE)
    service.evaluate(0.05)
    assert _place(service)["mean"]["error_m"] == pytest.approx(0.05)
    again(service.data, None, everything=True)
    assert service.evaluate(0.09) == 4
    assert _place(service)["mean"]["error_m"] == pytest.approx(0.09)  # by the same service: nothing old is shown


def test_commands_for_organisers_want_a_folder_with_rules(
    tmp_path: Path, service: Service, capsys: pytest.CaptureFixture[str]
) -> None:
    for command in (["again"], ["team", "Ours"]):
        assert main(["contest", *command, "--data", str(tmp_path / "typo")]) == 2
        assert "there are no rules" in capsys.readouterr().err
        assert not (tmp_path / "typo").exists()
    assert main(["contest", "again", "--all", "--data", str(service.data)]) == 0
    assert capsys.readouterr().out == "0 runs are to be done, 0 no longer count\n"


def test_a_folder_without_the_packages_of_its_database_is_refused(
    service: Service, capsys: pytest.CaptureFixture[str]
) -> None:
    """As of a backup that is not whole: every run that waits was given up within seconds."""
    service.hand_in(service.ours)
    service.hand_in(service.theirs, CODE + b"# other\n")
    service.evaluate()
    next((service.data / "packages").iterdir()).unlink()
    data = ["--data", str(service.data)]
    assert main(["contest", "again", "--all", *data]) == 2
    assert "1 of 2 packages that are to be run are not there" in capsys.readouterr().err
    require_packages(service.store, service.data)  # nothing is to be run
    for file in (service.data / "packages").iterdir():
        file.unlink()
    service.hand_in(service.ours, CODE + b"# third\n")
    next((service.data / "packages").iterdir()).unlink()
    assert main(["contest", "work", "--until-empty", *data]) == 2
    assert "1 of 1 packages that are to be run are not there" in capsys.readouterr().err
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    assert main(["contest", "serve", "--workers", "0", "--port", str(port), *data]) == 2
    said = capsys.readouterr()
    assert "1 of 1 packages that are to be run are not there" in said.err and not said.out  # no address of nothing
    assert queue.waiting(service.store) == 4


def test_a_port_that_another_program_has_is_told(service: Service, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        for port, why in ((other.getsockname()[1], "Address already in use"), (70000, "0-65535")):
            assert main(["contest", "serve", "--data", str(service.data), "--workers", "0", "--port", str(port)]) == 2
            said = capsys.readouterr()
            assert f"cannot listen at 127.0.0.1, port {port}: " in said.err and why in said.err
            assert said.out == ""
