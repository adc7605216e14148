"""The web service: who may do what, what is refused, and that nothing is lost or done twice."""

from __future__ import annotations

import io
import os
import socket
import threading
import time
import zipfile
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

import uvicorn
from fastapi.testclient import TestClient
from sqlalchemy import select, update

from tamp.contest.evaluation.trial import Trial
from tamp.contest.sandbox.choice import choose
from tamp.contest.sandbox.isolation import Ending
from tamp.contest.sandbox.plain import Plain
from tamp.contest.service import queue
from tamp.contest.service import submissions as handing_in
from tamp.contest.service.app import make_app
from tamp.contest.service.contest import load_contest
from tamp.contest.service.prompt import PromptProtocol
from tamp.contest.service.scratch import scratch_folder
from tamp.contest.service.store import TRIALS, Store, StoreFullError, open_store
from tamp.contest.service.teams import add_team, renew_token, team_of
from tamp.contest.service.worker import MOST_CLAIMS, Worker
from tamp.errors import TampError
from tamp.results import Result, to_json

CODE = b"class Solution:\n    def run(self, goal, robot): ...\n"
TASK = """\
name: {name}
objects:
  - name: red
    shape: {{box: [0.04, 0.04, 0.06]}}
    pose: {{xyz: [0, 0.1, 0.03]}}
    goal: {{pose: {{xyz: [0, -0.1, 0.03]}}}}
"""
RULES = """\
name: cup
contest: [hidden_*.yaml]
trial: [open.yaml]
runs: 2
uploads: {size_kb: 4, unpacked_kb: 64, a_month: 3, a_minute: 50}
"""


class Service:
    """A service in a folder, and two teams."""

    def __init__(self, data: Path) -> None:
        (data / "contest.yaml").write_text(RULES)
        for name in ("hidden_a", "hidden_b", "open"):
            (data / f"{name}.yaml").write_text(TASK.format(name=f"{name}_secret" if "hidden" in name else name))
        self.data, self.store, self.contest = data, open_store(data), load_contest(data / "contest.yaml")
        self.tokens = {
            name: add_team(self.store, name) for name in ("ours", "<script>alert(1)</script>'; DROP TABLE teams")
        }
        self.ours, self.theirs = self.tokens.values()
        self.client = TestClient(make_app(self.store, self.contest, data), raise_server_exceptions=False)

    def hand_in(self, token: str, code: bytes = CODE, name: str = "solution.py", kind: str = "contest"):  # type: ignore[no-untyped-def]
        headers = {"Authorization": f"Bearer {token}"}
        return self.client.post("/api/submissions", params={"name": name, "kind": kind}, headers=headers, content=code)

    def get(self, path: str, token: str | None = None):  # type: ignore[no-untyped-def]
        return self.client.get(path, headers={} if token is None else {"Authorization": f"Bearer {token}"})

    def evaluate(self, ede_m: float = 0.1, log: str = "printed") -> int:
        """Do all runs as a worker would; how many there were."""
        count = 0
        while (held := queue.claim(self.store)) is not None:
            result = Result(held.task, held.run, "failed", ede_m=ede_m, execution_sim_s=3.0, simulator=held.simulator)
            assert queue.finish(self.store, held, to_json(result), log)
            count += 1
        return count


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    made = Service(tmp_path)
    yield made
    made.store.close()


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


def test_what_is_wrong_is_refused_and_leaves_nothing(service: Service) -> None:
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("solution.py", CODE)
        archive.writestr("zeros", bytes(1 << 20))
    for code, name, status in (
        (bomb.getvalue(), "bomb.zip", 422),
        (b"no zip", "x.zip", 422),
        (CODE, "x.exe", 422),
        (CODE, "", 422),
        (b"#" * 5000, "solution.py", 413),
    ):
        answer = service.hand_in(service.ours, code, name)
        assert (answer.status_code, isinstance(answer.json()["detail"], str)) == (status, True), answer.text
    assert service.hand_in(service.ours, kind="other").status_code == 422
    assert service.get("/api/submissions", service.ours).json() == []
    assert [p for p in service.data.rglob("*") if p.is_file() and p.parent.name in ("incoming", "packages")] == []


def test_a_length_that_lies_is_not_believed(service: Service) -> None:
    def endless() -> Iterator[bytes]:
        for _ in range(1000):
            yield b"#" * 1000

    headers = {"Authorization": f"Bearer {service.ours}"}
    answer = service.client.post("/api/submissions", params={"name": "x.py"}, headers=headers, content=endless())
    assert answer.status_code == 413


def test_the_same_file_is_one_submission_and_a_month_has_so_many(service: Service) -> None:
    first = service.hand_in(service.ours)
    again = service.hand_in(service.ours)
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json()["id"] == again.json()["id"]
    assert service.hand_in(service.theirs).json()["id"] != first.json()["id"]
    for number in (2, 3):
        assert service.hand_in(service.ours, CODE + b"#%d\n" % number).status_code == 201
    refused = service.hand_in(service.ours, CODE + b"#4\n")
    assert refused.status_code == 429 and "next month" in refused.json()["detail"]
    assert service.hand_in(service.ours, kind="trial").status_code == 201


def test_the_same_file_from_many_sides_at_once_is_one_submission(service: Service) -> None:
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: service.hand_in(service.ours), range(8)))
    assert sorted(answer.status_code for answer in answers) == [200] * 7 + [201]
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert len(service.get("/api/submissions", service.ours).json()) == 1
    assert service.evaluate() == 2 * 2


@pytest.mark.parametrize(
    "name",
    ["a\0b.py", "a\nb.py", "\u202eyp.py", "\x1b[2J.py", "../../contest.yaml", "a.py/../../../x", "con.py\r\nX: y"],
)
def test_names_of_files_that_are_none_are_refused(service: Service, name: str) -> None:
    assert service.hand_in(service.ours, name=name).status_code == 422


@pytest.mark.parametrize("name", ["<img src=x onerror=alert(1)>.py", "'; DROP TABLE submissions; --.py", "../../up.py"])
def test_names_of_files_are_only_shown(service: Service, name: str) -> None:
    number = service.hand_in(service.ours, name=name).json()["id"]
    pages = [service.get(path, service.ours).text for path in ("/team", f"/submissions/{number}")]
    assert all("<img src=x" not in page for page in pages)
    (shown,) = [one["id"] for one in service.get("/api/submissions", service.ours).json()]
    assert shown == number and service.evaluate() == 2 * 2
    assert {path.parent for path in service.data.rglob("*.py")} == {service.data / "packages"}


def test_what_a_killed_server_left_of_uploads_goes_in_time(service: Service) -> None:
    incoming = service.data / "incoming"
    (incoming / "old").write_text("half")
    (incoming / "unpacked").mkdir()
    (incoming / "new").write_text("being received")
    for name in ("old", "unpacked"):
        os.utime(incoming / name, (0, 0))
    handing_in.clear_incoming(service.data)
    assert [path.name for path in incoming.iterdir()] == ["new"]


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


@pytest.mark.parametrize("page", ["films", "submissions", "api/submissions", "pictures/trial"])
@pytest.mark.parametrize(
    "number", ["9" * 24 + ".gif", "-1.gif", "0.gif", "%00", "'%20OR%201=1", "%ed%a0%80.png", "..%2fx"]
)
def test_numbers_that_are_none_lead_nowhere(service: Service, page: str, number: str) -> None:
    assert service.get(f"/{page}/{number}", service.ours).status_code in (404, 422)


def test_what_is_no_upload_is_small(service: Service) -> None:
    answer = service.client.post("/api/session", json={"token": "x" * 10_000})
    assert answer.status_code == 413 and "content-security-policy" in answer.headers
    chunks = (b'{"token":' for _ in range(10))
    assert service.client.post("/api/session", content=chunks).status_code == 413
    for token in ('"\\ud800"', '"\\u0000"', '"\\u00e9"'):
        answer = service.client.post(
            "/api/session", content=f'{{"token": {token}}}', headers={"Content-Type": "application/json"}
        )
        assert answer.status_code == 401


def test_uploads_have_a_rate(tmp_path: Path) -> None:
    service = Service(tmp_path)
    (tmp_path / "contest.yaml").write_text(RULES.replace("a_minute: 50", "a_minute: 2"))
    service.client = TestClient(make_app(service.store, load_contest(tmp_path / "contest.yaml"), tmp_path))
    assert [service.hand_in(service.ours, b"no zip", "x.zip").status_code for _ in range(3)] == [422, 422, 429]
    assert service.hand_in(service.theirs).status_code == 201


def test_a_full_disk_loses_nothing(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(handing_in, "_keep", full)
        answer = service.hand_in(service.ours)
        assert answer.status_code == 507 and "nothing is lost" in answer.json()["detail"]
    with monkeypatch.context() as patch:
        patch.setattr(handing_in, "_insert", lambda *_: (_ for _ in ()).throw(StoreFullError("full")))
        assert service.hand_in(service.ours).status_code == 507
    assert service.get("/api/submissions", service.ours).json() == []
    assert service.hand_in(service.ours).status_code == 201


def test_log_in_keeps_the_token_where_scripts_cannot_read_it(service: Service) -> None:
    assert service.client.post("/api/session", json={"token": "wrong"}).status_code == 401
    answer = service.client.post("/api/session", json={"token": service.ours})
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie and "samesite=strict" in cookie
    page = service.get("/team")
    assert "Hand in" in page.text and "default-src 'self'" in page.headers["content-security-policy"]
    assert service.client.delete("/api/session").status_code == 200
    assert "Log in" in service.get("/team").text


def test_tokens_are_kept_as_hashes_and_can_be_renewed(service: Service) -> None:
    assert service.ours.encode() not in b"".join(p.read_bytes() for p in service.data.glob("contest.db*"))
    new = renew_token(service.store, "ours")
    assert team_of(service.store, service.ours) is None
    found = team_of(service.store, new)
    assert found is not None and found.name == "ours"
    for name in ("ours", "", "x" * 100, "a\nb", "a\u202eb"):
        with pytest.raises(TampError):
            add_team(service.store, name)
    with pytest.raises(TampError, match="no team called"):
        renew_token(service.store, "nobody")


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


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 201),
        ({"Sec-Fetch-Site": "same-origin", "Origin": "https://behind.a.proxy"}, 201),
        ({"Origin": "http://testserver"}, 201),
        ({"Sec-Fetch-Site": "same-site"}, 403),
        ({"Sec-Fetch-Site": "cross-site"}, 403),
        ({"Origin": "http://testserver:9999"}, 403),
        ({"Origin": "null"}, 403),
    ],
)
def test_pages_of_others_do_nothing_with_a_session(service: Service, headers: dict[str, str], status: int) -> None:
    service.client.cookies.set("tamp_contest_token", service.ours)
    answer = service.client.post("/api/submissions", params={"name": "a.py"}, headers=headers, content=CODE)
    assert answer.status_code == status


def test_nothing_is_kept_in_caches_that_others_share_and_pages_need_nothing_from_elsewhere(service: Service) -> None:
    for page in ("/", "/rules", "/team", "/api/docs", "/api/leaderboard", "/nowhere"):
        answer = service.get(page, service.ours)
        assert answer.headers["Cache-Control"] == "private, no-cache"
        assert "http" not in answer.headers["Content-Security-Policy"]
        assert "://" not in answer.text
    docs = service.get("/api/docs").text
    assert "POST /api/submissions" in docs and "contest or trial" in docs
    assert service.get("/redoc").status_code == 404


def test_a_form_is_no_file(service: Service) -> None:
    headers = {"Authorization": f"Bearer {service.ours}"}
    answer = service.client.post("/api/submissions?name=a.py", headers=headers, files={"file": ("a.py", CODE)})
    assert answer.status_code == 415 and "--data-binary" in answer.json()["detail"]
    assert not service.get("/api/submissions", service.ours).json()


def test_names_that_look_like_a_teams_are_refused(service: Service) -> None:
    for name in ("Ours", "OURS", "\uff4f\uff55\uff52\uff53"):
        with pytest.raises(TampError, match="looks like the team 'ours'"):
            add_team(service.store, name)
    with pytest.raises(TampError, match="there is a team called"):
        add_team(service.store, "ours")


def test_an_upload_that_takes_for_ever_is_ended(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    import anyio

    async def trickle() -> AsyncIterator[bytes]:
        while True:
            yield b" "
            await anyio.sleep(0.01)

    monkeypatch.setattr("tamp.contest.service.app.UPLOAD_S", 0.2)
    headers = {"Authorization": f"Bearer {service.ours}"}

    async def hand_in() -> int:
        from httpx import ASGITransport, AsyncClient

        transport = ASGITransport(app=service.client.app)
        async with AsyncClient(transport=transport, base_url="http://testserver") as client:
            url = "/api/submissions?name=a.py"
            return (await client.post(url, headers=headers, content=trickle())).status_code

    assert anyio.run(hand_in) == 408
    assert not list((service.data / "incoming").iterdir())


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


def test_a_connection_that_does_not_ask_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tamp.contest.service.prompt.HEADER_S", 0.1)

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
