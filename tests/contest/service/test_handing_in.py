"""Handing in: what is refused, what counts once, and that nothing of it stays behind."""

from __future__ import annotations

import errno
import io
import re
import time
import zipfile
from collections.abc import AsyncIterator, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from fastapi.testclient import TestClient

from tamp.contest.service import submissions as handing_in
from tamp.contest.service.contest import load_contest
from tamp.contest.service.store import StoreFullError
from tamp.contest.service.web.app import make_app
from tests.contest.service.served import CODE, RULES, Service


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
    assert not list(service.data.rglob("packages/*")) and not list(service.data.glob("scratch/*/"))


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


def test_uploads_have_a_rate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    service = Service(tmp_path)
    (tmp_path / "contest.yaml").write_text(RULES.replace("a_minute: 50", "a_minute: 2"))
    service.client = TestClient(make_app(service.store, load_contest(tmp_path / "contest.yaml"), tmp_path))
    assert [service.hand_in(service.ours, b"no zip", "x.zip").status_code for _ in range(3)] == [422, 422, 429]
    assert service.hand_in(service.theirs).status_code == 201
    with monkeypatch.context() as patch:  # a clock that is put right bars nobody until it has caught up
        patch.setattr(handing_in, "time", SimpleNamespace(time=lambda: time.time() - 3600))
        assert service.hand_in(service.ours).status_code == 201


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


def test_a_full_disk_is_told_wherever_something_is_written(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tamp.contest.service.web.pictures.render_task", full)
    monkeypatch.setattr("tamp.contest.service.web.pictures.save_task", full)
    for path in ("/pictures/trial/open.png", "/api/tasks/trial.zip"):
        answer = service.get(path)
        assert answer.status_code == 507 and "disk is full" in answer.json()["detail"]
    monkeypatch.undo()
    assert service.get("/api/tasks/trial.zip").status_code == 200  # made when there is room, and then kept
    monkeypatch.setattr("tamp.contest.service.web.pictures.save_task", full)
    assert service.get("/api/tasks/trial.zip").status_code == 200


def test_a_form_is_no_file(service: Service) -> None:
    headers = {"Authorization": f"Bearer {service.ours}"}
    answer = service.client.post("/api/submissions?name=a.py", headers=headers, files={"file": ("a.py", CODE)})
    assert answer.status_code == 415 and "--data-binary" in answer.json()["detail"]
    assert not service.get("/api/submissions", service.ours).json()


def test_an_upload_that_takes_for_ever_is_ended(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    import anyio

    async def trickle() -> AsyncIterator[bytes]:
        while True:
            yield b" "
            await anyio.sleep(0.01)

    monkeypatch.setattr("tamp.contest.service.web.uploads.UPLOAD_S", 0.2)
    headers = {"Authorization": f"Bearer {service.ours}"}

    async def hand_in() -> int:
        from httpx import ASGITransport, AsyncClient

        transport = ASGITransport(app=service.client.app)
        async with AsyncClient(transport=transport, base_url="http://testserver") as client:
            url = "/api/submissions?name=a.py"
            return (await client.post(url, headers=headers, content=trickle())).status_code

    assert anyio.run(hand_in) == 408
    assert not list(service.data.glob("scratch/*/"))


def test_a_team_that_keeps_uploads_open_has_only_so_many_at_once(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    import anyio
    from httpx import ASGITransport, AsyncClient

    async def trickle() -> AsyncIterator[bytes]:
        while True:
            yield b" "
            await anyio.sleep(0.01)

    monkeypatch.setattr("tamp.contest.service.web.uploads.UPLOAD_S", 0.5)
    monkeypatch.setattr("tamp.contest.service.web.app.count_attempt", lambda *_: None)  # others were begun long ago
    (service.data / "contest.yaml").write_text(RULES.replace("a_minute: 50", "a_minute: 2"))
    app = make_app(service.store, load_contest(service.data / "contest.yaml"), service.data)
    found = []

    async def hand_in(token: str, content: bytes | AsyncIterator[bytes]) -> None:
        async with AsyncClient(transport=ASGITransport(app=app), base_url="http://testserver") as client:
            headers = {"Authorization": f"Bearer {token}"}
            answer = await client.post("/api/submissions?name=a.py", headers=headers, content=content)
            found.append((answer.status_code, "under way" in answer.text))

    async def several() -> None:
        async with anyio.create_task_group() as group:
            for _ in range(2):
                group.start_soon(hand_in, service.ours, trickle())
            while len(list(service.data.glob("scratch/*/upload"))) < 2:
                await anyio.sleep(0.01)
            await hand_in(service.ours, CODE)
            await hand_in(service.theirs, CODE)
        await hand_in(service.ours, CODE)

    anyio.run(several)
    assert found == [(429, True), (201, False), (408, False), (408, False), (201, False)]


def test_an_upload_whose_sender_goes_away_leaves_nothing_and_is_no_error(service: Service) -> None:
    import anyio

    scope = {
        "type": "http", "http_version": "1.1", "method": "POST", "path": "/api/submissions",
        "query_string": b"name=a.py",
        "headers": [(b"authorization", f"Bearer {service.ours}".encode()), (b"content-length", b"1000")],
    }  # fmt: skip
    parts = [{"type": "http.request", "body": b"class", "more_body": True}, {"type": "http.disconnect"}]

    async def receive() -> dict[str, object]:
        return parts.pop(0)

    async def send(_: object) -> None: ...

    anyio.run(service.client.app, scope, receive, send)  # it raised, and the server's log had a traceback
    assert not parts and not list(service.data.glob("scratch/*/"))
    assert not service.get("/api/submissions", service.ours).json()


def test_a_refusal_calls_the_file_as_its_team_does(service: Service) -> None:
    answer = service.hand_in(service.ours, b"no zip", "our best.zip")
    assert answer.json()["detail"] == "our best.zip: is no zip that can be read: it has no directory"


def test_what_can_hold_no_solution_uses_up_no_submission(service: Service) -> None:
    """It was accepted, failed in all of its runs, and counted."""
    package = io.BytesIO()
    with zipfile.ZipFile(package, "w") as archive:
        archive.writestr("solution/__init__.py", "from solution import other")
        archive.writestr("solution/other.py", CODE)
    for code, name, why in (
        (b"def solve(goal, robot): ...", "ours.py", "ours.py has no class Solution with run"),
        (b"class Solution\n", "ours.py", r"ours.py is no Python 3.\d+: line 1: "),
        (package.getvalue(), "ours.zip", "ours.zip: __init__.py has no class Solution with run"),
    ):
        answer = service.hand_in(service.ours, code, name)
        assert answer.status_code == 422 and re.match(why, answer.json()["detail"]), answer.text
    assert service.get("/api/submissions", service.ours).json() == [] and not list(service.data.glob("packages/*"))
    assert "(3 left this month)" in service.get("/team", service.ours).text
