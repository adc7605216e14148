"""Pages and API: what is ranked and shown, to whom, and what leads nowhere."""

from __future__ import annotations

import io
import re
import socket
import threading
import zipfile
from collections.abc import Awaitable, Callable

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

import uvicorn
from fastapi.testclient import TestClient

from tamp.contest.service import queue
from tamp.contest.service.contest import load_contest
from tamp.contest.service.web.app import make_app
from tamp.contest.service.web.prompt import PromptProtocol
from tamp.results import Result, to_json
from tests.contest.service.served import CODE, Service


def test_a_submission_is_evaluated_and_ranked(service: Service) -> None:
    answer = service.hand_in(service.ours)
    assert answer.status_code == 201
    number = answer.json()["id"]
    assert service.get(f"/api/submissions/{number}").json()["state"] == "queued"
    assert service.evaluate(0.05) == 2 * 2
    service.hand_in(service.theirs, CODE + b"# other\n")
    service.evaluate(0.08)
    places = service.get("/api/leaderboard").json()["places"]
    assert [(p["rank"], p["team"][:8]) for p in places] == [(1, "ours"), (2, "<script>")]
    assert places[0]["mean"]["error_m"] == pytest.approx(0.05)
    page = service.get("/").text
    assert "5.00" in page and "&lt;script&gt;" in page and "<script>alert" not in page
    assert service.get(f"/submissions/{number}").status_code == 200


def test_pages_and_api_keep_hidden_tasks_hidden(service: Service) -> None:
    service.hand_in(service.ours)
    service.evaluate()
    for path in (
        "/",
        "/rules",
        "/tasks",
        "/team",
        "/api/tasks",
        "/api/leaderboard",
        "/api/export",
        "/api/openapi.json",
    ):
        answer = service.get(path, service.ours)
        assert answer.status_code == 200, path
        assert "_secret" not in answer.text, path
    assert service.get("/pictures/contest/001.png").status_code == 404
    assert service.get("/pictures/trial/..%2f..%2fcontest.yaml.png").status_code == 404
    archive = zipfile.ZipFile(io.BytesIO(service.get("/api/tasks/trial.zip").content))
    assert archive.namelist() == ["open/task.yaml"]


def test_what_is_not_there_is_a_page_for_readers_and_json_for_programs(service: Service) -> None:
    browser = {"Accept": "text/html,*/*;q=0.8"}
    for path in ("/nowhere", "/submissions/99"):
        answer = service.client.get(path, headers=browser)
        assert (answer.status_code, answer.headers["Content-Type"].partition(";")[0]) == (404, "text/html"), path
        assert "<h1>Not found</h1>" in answer.text and "there is no such" in answer.text
        assert set(service.get(path).json()) == {"detail"}
    assert set(service.client.get("/api/submissions/99", headers=browser).json()) == {"detail"}


def test_logs_and_trial_submissions_are_their_owners_only(service: Service) -> None:
    contest = service.hand_in(service.ours).json()["id"]
    trial = service.hand_in(service.ours, kind="trial").json()["id"]
    service.evaluate(log="my own words")
    for number, status in ((contest, 200), (trial, 404)):
        for token in (None, service.theirs, "x" * 40, "x" * 400):
            for path in (f"/submissions/{number}", f"/api/submissions/{number}"):
                answer = service.get(path, token)
                assert answer.status_code == status
                assert "my own words" not in answer.text and "solution.py" not in answer.text
        assert "my own words" in service.get(f"/submissions/{number}", service.ours).text
        assert "my own words" in service.get(f"/api/submissions/{number}", service.ours).text
    assert service.get("/api/submissions", service.theirs).json() == []
    exported = service.get("/api/export", service.theirs).json()["submissions"]
    assert [s["kind"] for s in exported] == ["contest"] and exported[0]["file"] == ""
    for path in ("/api/submissions", "/api/export"):
        assert service.get(path).status_code == 401
    assert service.hand_in("").status_code == 401


@pytest.mark.parametrize("page", ["films", "submissions", "api/submissions", "pictures/trial"])
@pytest.mark.parametrize(
    "number", ["9" * 24 + ".gif", "-1.gif", "0.gif", "%00", "'%20OR%201=1", "%ed%a0%80.png", "..%2fx"]
)
def test_numbers_that_are_none_lead_nowhere(service: Service, page: str, number: str) -> None:
    assert service.get(f"/{page}/{number}", service.ours).status_code in (404, 422)


def test_nothing_is_kept_in_caches_that_others_share_and_pages_need_nothing_from_elsewhere(service: Service) -> None:
    for page in ("/", "/rules", "/team", "/api/docs", "/api/leaderboard", "/nowhere"):
        answer = service.get(page, service.ours)
        assert answer.headers["Cache-Control"] == "private, no-cache"
        assert "http" not in answer.headers["Content-Security-Policy"]
        assert "://" not in answer.text
    docs = service.get("/api/docs").text
    assert "POST /api/submissions" in docs and "contest or trial" in docs
    assert service.get("/redoc").status_code == 404


def test_a_connection_that_does_not_ask_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tamp.contest.service.web.prompt.HEADER_S", 0.1)

    async def app(scope: object, receive: object, send: Callable[..., Awaitable[None]]) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"0")]})
        await send({"type": "http.response.body"})

    server = uvicorn.Server(uvicorn.Config(app, port=0, http=PromptProtocol, lifespan="off", log_level="warning"))
    with socket.create_server(("127.0.0.1", 0)) as listening:
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            for said in (b"", b"GET / HTTP/1.1\r\nHost: x\r\n", b"GET / HTTP/1.1\r\nHost: x\r\n\r\nGET / HT"):
                with socket.create_connection(listening.getsockname(), timeout=30) as slow:
                    slow.sendall(said)
                    answer = b""
                    while piece := slow.recv(1000):  # ends where the server has closed
                        answer += piece
                assert answer.startswith(b"HTTP/1.1 200") == said.endswith(b"HT")
        finally:
            server.should_exit = True
            thread.join()


def test_a_page_says_how_a_solution_is_written_and_names_every_call(service: Service) -> None:
    page = service.get("/solutions").text
    for said in ("goal, robot", "frame(name)", "move_pose(T_world_tool, speed=1.0, straight=True)", "T_world_camera",
                 "tf(parent, child)", "follow(times, positions, velocities=None)", "go_to(width, effort=20.0)",
                 "time_left", "finger pads", "home, lower, upper"):  # fmt: skip
        assert said in page, said
    assert 'href="/solutions"' in service.get("/").text
    assert page.count('<table class="calls">') == page.count("<table")  # on phones what a call does stands below it
    assert "@media (max-width: 40rem) { .calls tr" in service.get("/static/style.css").text


def test_what_pages_say_is_said_in_full(service: Service) -> None:
    """Sizes in units that people use, one run in the singular, and nothing of the framework's own words."""
    assert "4 KiB, unpacked 64 KiB" in service.get("/rules").text and "4 GiB of memory" in service.get("/rules").text
    number = service.hand_in(service.ours).json()["id"]
    held = queue.claim(service.store)
    assert held is not None
    queue.put_off(service.store, held, "no room")
    for page in ("/", f"/submissions/{number}"):
        assert "1 run could not be begun" in service.get(page).text and "it is tried again" in service.get(page).text
    docs = service.get("/api/docs").text
    assert "Validation Error" not in docs and "Successful Response" not in docs


def test_a_team_sees_what_it_has_left_this_month(service: Service) -> None:
    assert "(3 left this month)" in service.get("/team", service.ours).text
    service.hand_in(service.ours)
    assert "(2 left this month)" in service.get("/team", service.ours).text
    assert "(3 left this month)" in service.get("/team", service.theirs).text


def test_a_task_without_a_goal_pose_takes_no_figures_of_another(service: Service) -> None:
    (service.data / "another.yaml").write_text(
        "name: another\nregions: [{name: tray, box: {center: [0.1, -0.3], size: [0.2, 0.2]}}]\n"
        "objects:\n  - {name: red, shape: {box: [0.04, 0.04, 0.06]}, pose: {xyz: [0, 0.1, 0.03]}, goal: {on: tray}}\n"
    )
    rules = (service.data / "contest.yaml").read_text().replace("[open.yaml]", "[another.yaml, open.yaml]")
    (service.data / "contest.yaml").write_text(rules)
    contest = load_contest(service.data / "contest.yaml")
    client = TestClient(make_app(service.store, contest, service.data))
    another, own = client.get("/tasks").text.split("<figure>")[1:]
    assert "<b>another</b>" in another and "no goal is a pose" in another and "doing nothing" not in another
    assert "<b>open</b>" in own and "doing nothing 20.00" in own


def test_a_contest_without_trial_tasks_offers_none_to_download(service: Service) -> None:
    offered = "/api/tasks/trial.zip"
    assert offered in service.get("/tasks").text and "download the trial tasks" in service.get("/").text
    rules = (service.data / "contest.yaml").read_text().replace("[open.yaml]", "[]").replace("hidden_*", "hidden_a")
    (service.data / "contest.yaml").write_text(rules)
    client = TestClient(make_app(service.store, load_contest(service.data / "contest.yaml"), service.data))
    page = client.get("/tasks").text
    assert "no trial tasks" in page and offered not in page and "1 task, which stays on the server" in page
    assert "download" not in client.get("/").text
    team = {"Authorization": f"Bearer {service.ours}"}
    for path in ("/solutions", "/team"):
        assert "trial" in service.get(path, service.ours).text
        assert "trial" not in client.get(path, headers=team).text, path


def test_what_a_solution_printed_is_shown_line_by_line_with_all_that_it_has(service: Service) -> None:
    number = service.hand_in(service.ours).json()["id"]
    service.evaluate(0.2 + 1e-5, "one\x1b[2J\n\ttwo \u202e\u2066three\r\nfour <b>")
    assert "one\ufffd[2J\n        two \ufffd\ufffdthree\nfour &lt;b&gt;</pre>" in (
        service.get(f"/submissions/{number}", service.ours).text
    )
    assert "-0.0" not in service.get("/").text


def test_a_team_finds_its_row_and_what_went_wrong(service: Service) -> None:
    """Its row is marked; failed runs are counted above what they printed, of which a page has the end."""
    number = service.hand_in(service.ours).json()["id"]
    service.hand_in(service.theirs, CODE + b"# other\n")
    for message in ("raised: ZeroDivisionError", *[""] * 7):
        held = queue.claim(service.store)
        assert held is not None
        result = Result(held.task, held.run, "failed", ede_m=0.1, simulator=held.simulator, message=message)
        assert queue.finish(service.store, held, to_json(result), "begin" + "x" * 30_000 + "end")
    board, others = service.get("/", service.ours).text, service.get("/").text
    assert board.count(' mine">') == 1 and board.count('class="mine"') == 1 and "mine" not in others
    assert others.count("<bdi>ours</bdi>") == 2, "in the board, and in a row of its errors of each task"
    page = service.get(f"/submissions/{number}", service.ours).text
    assert re.findall(r"<b>(.*?)</b>.*?</meter> (.*?)</td>", page) == [("10.00", "50.0 %")] * 3, "two tasks, their mean"
    assert "1 of 4 runs did not end well" in page
    assert "xend</pre>" in page and "begin" not in page and "the API has all 30008" in page
    assert "did not end well" not in service.get(f"/submissions/{number}").text
    followed = service.get(f"/api/submissions/{number}?runs=false", service.ours)  # as its page asks again and again
    assert followed.json()["file"] == "solution.py" and len(followed.content) < 1000
    assert f"{number}?runs=false" in service.get("/static/contest.js").text.replace("${live.dataset.number}", number)
