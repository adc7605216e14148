"""What organisers do beside the rules: withdraw and restore submissions and teams, list all, carry teams over."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from tamp.cli import main
from tamp.contest.evaluation.trial import Trial
from tamp.contest.package import Package
from tamp.contest.sandbox.choice import choose
from tamp.contest.sandbox.isolation import Ending
from tamp.contest.service import queue
from tamp.contest.service import worker as working
from tamp.contest.service.teams import team_names
from tamp.contest.service.withdrawn import withdraw_unloadable
from tamp.results import Result
from tests.contest.service.served import CODE, RULES, Service


def test_a_withdrawn_submission_is_neither_run_nor_ranked_nor_handed_in_again_and_can_be_restored(
    service: Service, capsys: pytest.CaptureFixture[str]
) -> None:
    data = ["--data", str(service.data)]
    first = service.hand_in(service.ours).json()["id"]
    service.evaluate(0.05)
    second = service.hand_in(service.ours, CODE + b"#2").json()["id"]
    held = queue.claim(service.store)
    assert held is not None
    assert main(["contest", "withdraw", first, second, "--why", "it is <b>ours</b>", *data]) == 0
    assert not queue.finish(service.store, held, "late", "") and queue.claim(service.store) is None
    assert service.get("/api/leaderboard").json()["places"] == []
    assert service.get("/api/export", service.ours).json()["submissions"] == []
    assert service.get(f"/submissions/{first}", service.theirs).status_code == 404
    told = service.client.get(
        f"/submissions/{first}", headers={"Authorization": f"Bearer {service.ours}", "Accept": "text/html"}
    )
    assert told.status_code == 410 and "Withdrawn</h1>" in told.text and "it is &lt;b&gt;ours&lt;/b&gt;" in told.text
    page = service.get("/team", service.ours).text
    assert "(1 left this month)" in page and page.count("it is &lt;b&gt;ours&lt;/b&gt;") == 2
    assert "this file was withdrawn: it is" in service.hand_in(service.ours).json()["detail"]
    assert queue.refresh(service.store, service.contest).queued == ()  # it stays so whatever changes
    capsys.readouterr()
    assert main(["contest", "status", *data]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"{second}  contest  withdrawn  ours: solution.py (it is <b>ours</b>)",
        f"{first}  contest  withdrawn  ours: solution.py (it is <b>ours</b>)",
        "nothing is put off",
    ]
    assert main(["contest", "again", "--restore", first, second, *data]) == 0
    assert service.get("/api/leaderboard").json()["places"][0]["submission"] == first
    assert service.evaluate() == 4 and "Withdrawn" not in service.get("/team", service.ours).text
    assert main(["contest", "status", *data]) == 0
    assert f"{second}  contest  done       4/4  ours: solution.py" in capsys.readouterr().out


def test_what_is_given_back_does_not_count_in_its_month(service: Service) -> None:
    numbers = [service.hand_in(service.ours, CODE + b"#%d" % n).json()["id"] for n in range(3)]
    assert service.hand_in(service.ours, CODE + b"#3").status_code == 429
    assert main(["contest", "withdraw", numbers[0], "--give-back", "--data", str(service.data)]) == 0
    assert service.hand_in(service.ours, CODE + b"#3").status_code == 201
    assert service.hand_in(service.ours, CODE + b"#4").status_code == 429


def test_what_cannot_be_loaded_uses_up_no_submission_and_its_team_reads_why(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is told before it has seen a hidden task; else every run could be looked at for nothing."""

    def unloadable(package: Package, *_: object) -> tuple[str, bytes]:
        return "no module <b>" if "nowhere" in package.source.read_text() else "", b""

    def runs(*_: object, run: int, **__: object) -> Trial:
        return Trial(Result("task", run, "failed", ede_m=0.1), Ending("finished"), b"", ())

    monkeypatch.setattr(working, "cannot_load", unloadable)
    monkeypatch.setattr(working, "run_trial", runs)
    numbers = [
        service.hand_in(service.ours, code).json()["id"] for code in (b"import nowhere\n" + CODE, CODE, CODE + b"#2")
    ]
    assert "(0 left this month)" in service.get("/team", service.ours).text
    others = queue.claim(service.store)  # another worker is at the same submission
    worker = working.Worker(service.store, service.contest, service.data, choose(insecure=True))
    assert others is not None and others.submission == numbers[0]
    while (held := queue.claim(service.store)) is not None:
        worker.do(held)
    worker.do(others)
    gone, first, second = (service.get(f"/api/submissions/{number}", service.ours) for number in numbers)
    assert gone.status_code == 410 and "withdrawn: it cannot be loaded: no module <b>" in gone.json()["detail"]
    assert first.json()["state"] == second.json()["state"] == "done"
    page = service.get("/team", service.ours).text
    assert "(1 left this month)" in page and "it cannot be loaded: no module &lt;b&gt;</span>" in page
    assert "does not count in its month" in page


def test_no_more_than_the_trials_of_a_month_are_given_back_for_what_cannot_be_loaded(service: Service) -> None:
    """Each takes a worker's time."""
    for number, given_back in enumerate((True, True, False)):
        service.hand_in(service.ours, CODE + b"#%d" % number)
        held = queue.claim(service.store)
        assert held is not None
        assert withdraw_unloadable(service.store, held, "why", most=2) == given_back
        assert not withdraw_unloadable(service.store, replace(held, lease="another's"), "why", most=9)
    assert "(2 left this month)" in service.get("/team", service.ours).text


def test_a_withdrawn_team_is_out_with_all_that_it_handed_in(service: Service) -> None:
    for token in (service.ours, service.theirs):
        service.hand_in(token)
    assert main(["contest", "withdraw", "--team", "ours", "--data", str(service.data)]) == 0
    assert service.hand_in(service.ours).status_code == 401
    assert service.evaluate() == 4
    assert [place["team"][:4] for place in service.get("/api/leaderboard").json()["places"]] == ["<scr"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["withdraw"], "say what is withdrawn"),
        (["withdraw", "none"], "no submission has the number none; nothing was changed"),
        (["withdraw", "--team", "our"], "did you mean 'ours'"),
        (["again", "--restore", "none"], "no submission has the number none; nothing was changed"),
    ],
)
def test_what_is_not_there_is_told(
    service: Service, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
) -> None:
    assert main(["contest", *arguments, "--data", str(service.data)]) == 2
    assert said in capsys.readouterr().err


def test_teams_are_carried_over_with_their_tokens(
    service: Service, tmp_path_factory: pytest.TempPathFactory, capsys: pytest.CaptureFixture[str]
) -> None:
    later = Service(_season(tmp_path_factory))
    try:
        names = ["contest", "carry", str(service.data), "--data", str(later.data)]
        assert main(names) == 2  # both have teams of these names with other tokens
        assert "ours" in capsys.readouterr().err and team_names(later.store) == team_names(service.store)
        with later.store.change() as connection:
            connection.exec_driver_sql("DELETE FROM teams")
        for said in ("2 teams are new here", "0 teams are new here"):
            assert main(names) == 0
            assert said in capsys.readouterr().out
        assert later.hand_in(service.ours).status_code == 201 and later.hand_in(later.ours).status_code == 401
    finally:
        later.store.close()


def _season(folders: pytest.TempPathFactory) -> Path:
    folder = folders.mktemp("season")
    (folder / "contest.yaml").write_text(RULES)
    return folder
