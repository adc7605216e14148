"""Films of runs: what cannot be kept or drawn is left out, and nothing else waits for it."""

from __future__ import annotations

import gzip

import pytest

pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from tamp.contest.service import films, queue
from tamp.execution.log import Frame
from tamp.results import Result, to_json
from tests.contest.service.served import Service

FRAMES = (Frame(0.0, {}, (0.0,), 0.0), Frame(0.4, {}, (0.0,), 0.0))


def _a_trial(service: Service) -> int:
    """A run that a film is to be made of."""
    service.hand_in(service.ours, kind="trial")
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
