"""Processes that are killed while they write: the next one to start clears away what they left, and nothing else."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from tamp.contest.service.scratch import scratch_folder
from tests.contest.service.served import Service

BEGIN = """\
import os, signal, sys
from pathlib import Path
from tamp.contest.service import films, queue, submissions
from tamp.execution.log import Frame
from tamp.results import Result, to_json
from tests.contest.service.served import Service

data = Path(sys.argv[1])
frames = [Frame(t, {}, (0.0,), 0.0) for t in (0.0, 0.4)]

def killed(*_, **__):
    os.kill(os.getpid(), signal.SIGKILL)

"""
WHILE = {
    "it keeps frames": "films.gzip.open = killed\nfilms.keep(data, 1, frames)",
    "it draws a film": """\
service = Service(data)
service.hand_in(service.ours, kind="trial")
while (held := queue.claim(service.store)) is not None:
    result = Result(held.task, held.run, "failed", improvement=0.5, simulator=held.simulator)
    queue.finish(service.store, held, to_json(result), "")
    films.keep(data, held.trial, frames)
films.render_execution = killed
films.make_one(service.store, service.contest, data)
""",
    "it draws a picture": """\
from tamp.contest.service.web import pictures
service = Service(data)
pictures.render_task = lambda task, poses, path, goals: killed(path.touch())
service.get("/pictures/trial/open.png")
""",
    "an upload is unpacked": "submissions.unpack = killed\nservice = Service(data)\nservice.hand_in(service.ours)",
}


@pytest.mark.parametrize("doing", WHILE)
def test_what_a_killed_process_left_goes_when_the_next_one_starts(tmp_path: Path, doing: str) -> None:
    command = [sys.executable, "-c", BEGIN + WHILE[doing], str(tmp_path)]
    assert subprocess.run(command, timeout=120, check=False).returncode == -signal.SIGKILL
    with scratch_folder(tmp_path) as folder:
        assert list(tmp_path.glob("scratch/*/")) == [folder]
    left = [path for name in ("films", "frames", "incoming", "pictures/trial") for path in tmp_path.glob(f"{name}/*")]
    assert all(path.name.endswith(".json.gz") for path in left), left


def test_what_living_processes_write_stays(service: Service) -> None:
    with scratch_folder(service.data) as folder:
        assert service.hand_in(service.ours).status_code == 201
        assert list(service.data.glob("scratch/*/")) == [folder]
