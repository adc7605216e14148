"""Films of runs: what cannot be kept or drawn is left out, and nothing else waits for it."""

from __future__ import annotations

import gzip
from dataclasses import replace

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from fastapi.testclient import TestClient

from tamp.contest.service import films, queue
from tamp.contest.service.web.app import make_app
from tamp.execution.log import Frame
from tamp.results import Result, to_json
from tests.contest.service.served import Service

FRAMES = (Frame(0.0, {}, (0.0,), 0.0), Frame(0.4, {}, (0.0,), 0.0))


def _a_trial(service: Service, kind: str = "trial") -> int:
    """A run that a film is to be made of."""
    service.hand_in(service.ours, kind=kind)
    while (held := queue.claim(service.store)) is not None:
        result = Result(held.task, held.run, "failed", improvement=0.5, simulator=held.simulator)
        assert queue.finish(service.store, held, to_json(result), "")
        trial = held.trial
    return trial


def test_frames_that_a_killed_worker_left_unfinished_end_no_other(service: Service) -> None:
    trial = _a_trial(service)
    (service.data / "frames").mkdir()
    left = service.data / "frames" / f"{trial}.json.gz"
    left.write_bytes(gzip.compress(b"[[0.0, {}, [0.0]")[:-4])
    while films.make_one(service.store, service.contest, service.data):
        pass
    assert not left.exists()
    assert not films.film_path(service.data, trial).exists()


def test_a_disk_without_room_costs_the_film_only(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(gzip, "open", full)
        films.keep(service.data, 1, FRAMES)
    assert list((service.data / "frames").iterdir()) == []
    films.keep(service.data, 1, FRAMES)
    assert [path.name for path in (service.data / "frames").iterdir()] == ["1.json.gz"]


def test_a_film_waits_for_room_on_the_disk(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its frames were thrown away, and there is no other film of that run."""

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    trial = _a_trial(service)
    films.keep(service.data, trial, FRAMES)
    for name, value in (("ROOM", 1 << 60), ("render_execution", full)):
        with monkeypatch.context() as patch:
            patch.setattr(films, name, value)
            assert not films.make_one(service.store, service.contest, service.data)
        assert [path.name for path in (service.data / "frames").iterdir()] == [f"{trial}.json.gz"]
    monkeypatch.setattr(films, "render_execution", lambda *given: given[-1].write_bytes(b"GIF89a"))
    assert films.make_one(service.store, service.contest, service.data)
    assert films.film_path(service.data, trial).exists() and not list((service.data / "frames").iterdir())


def test_films_of_hidden_tasks_are_shown_when_these_are_revealed(service: Service) -> None:
    _a_trial(service, "contest")
    (submission,) = service.get("/api/submissions", service.ours).json()
    number = submission["id"]
    (trial, *_) = films.shown(service.store, number)
    place = films.film_path(service.data, trial)
    place.parent.mkdir()
    place.write_bytes(b"GIF89a")
    assert service.get(f"/films/{trial}.gif", service.ours).status_code == 404
    assert "/films/" not in service.get(f"/submissions/{number}", service.ours).text
    revealed = replace(service.contest, rules=replace(service.contest.rules, reveal=True))
    client = TestClient(make_app(service.store, revealed, service.data))
    assert f"/films/{trial}.gif" in client.get(f"/submissions/{number}").text
    assert client.get(f"/films/{trial}.gif").content == b"GIF89a"
