"""What a solution's process sees of the file system."""

from __future__ import annotations

import os
import socket
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tamp.contest.sandbox import process
from tamp.contest.sandbox.choice import KINDS, choose
from tamp.contest.sandbox.isolation import ENVIRONMENT, Ending, Mount, Sandbox, visible
from tamp.contest.sandbox.process import SandboxedProcess
from tamp.contest.sandbox.runtime import interpreter, make_room
from tests.contest.cells import QUICK, EmptyCell, run_in


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_what_is_shown_below_tmp_is_seen_and_the_rest_of_tmp_is_its_own(kind: type[Sandbox], tmp_path: Path) -> None:
    """An interpreter that was unpacked there runs."""
    sandbox = kind()
    why_not = sandbox.missing()
    if why_not:
        pytest.skip(f"this machine has no {sandbox.name}: {why_not}")
    (tmp_path / "shown").mkdir()
    (tmp_path / "shown" / "file").write_text("seen")
    room = make_room(tmp_path / "shown", tmp_path / "shown", (), scratch_mb=4)
    room = replace(room, mounts=(*room.mounts, Mount(tmp_path / "shown", "/tmp/python/lib")))
    code = (
        "import os; print(open('/tmp/python/lib/file').read(), sorted(os.listdir('/tmp')), os.getcwd())\n"
        "open('/tmp/own', 'w').write('x' * 1000)\n"
        "try: open('/tmp/python/lib/own', 'w')\n"
        "except OSError as error: print(error.strerror)"
    )
    with SandboxedProcess(sandbox, room, [interpreter(), "-I", "-S", "-c", code], QUICK) as started:
        assert started.wait(20.0) == 0, started.output
    assert started.output.decode().split("\n")[:2] == ["seen ['python'] /tmp", "Read-only file system"]
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "shown"]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_the_environment_is_the_same_in_every_sandbox(kind: type[Sandbox], tmp_path: Path) -> None:
    if kind().missing():
        pytest.skip(kind().missing())
    solution = tmp_path / "solution.py"
    solution.write_text(
        "import os, pathlib\n\nclass Solution:\n    def run(self, goal, robot):\n"
        f"        assert {{**os.environ, **{dict(ENVIRONMENT)}}} == dict(os.environ)\n"
        "        assert pathlib.Path.home() == pathlib.Path('/tmp')\n"
    )
    ending, output = run_in(kind(), solution, tmp_path / "run")
    assert ending.reason == "finished", output


def test_words_of_solutions_are_in_one_line_that_can_be_seen() -> None:
    assert visible("a\tb\n\x1b[2J\u202e\ud800é") == "a b \ufffd[2J\ufffd\ufffdé"
    assert Ending("raised", "\0").message == "\ufffd"


def test_what_does_not_let_itself_be_looked_into_is_taken_to_hold_as_many_sockets_as_it_may(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of an ordinary user's processes, those that cannot be traced do not show their descriptors."""

    def unseen(_: int) -> dict[int, set[tuple[int, int]]]:
        raise PermissionError

    pair = socket.socketpair()
    seen = process.usage([os.getpid()], {})[2]
    with monkeypatch.context() as patch:
        patch.setattr(process, "_open", unseen)
        assert process.usage([os.getpid()], {})[2] - seen > 32 * process._queue()
    for end in pair:
        end.close()


COMPUTES = """
import threading, time

def compute():
    while time.thread_time() < 1.2: pass

class Solution:
    def run(self, goal, robot):
        worker = threading.Thread(target=compute)  # the first thread sleeps until it has ended
        worker.start()
        worker.join()
        robot.arm.state()
"""


def test_who_computes_or_waits_for_the_robot_is_not_idle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However long that takes on a busy machine: a simulator that takes its time is no fault of the solution's."""
    state = EmptyCell.state

    def slowly(cell: EmptyCell) -> tuple[Any, Any, float]:
        time.sleep(1.5)
        return state(cell)

    monkeypatch.setattr(EmptyCell, "state", slowly)
    solution = tmp_path / "solution.py"
    solution.write_text(COMPUTES)
    sandbox = choose(insecure=all(kind().missing() for kind in KINDS))
    ending, output = run_in(sandbox, solution, tmp_path / "run", replace(QUICK, idle_s=0.9))
    assert ending.reason == "finished", (ending, output)


ASKS = """
class Solution:
    def run(self, goal, robot):
        while True:
            robot.arm.state()
"""


def test_who_has_the_server_compute_while_no_simulated_time_passes_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pictures and what is refused cost the server much, and the task's clock little: a run could take hours so."""

    state = EmptyCell.state

    def costly(cell: EmptyCell) -> tuple[Any, Any, float]:
        end = time.process_time() + 0.05
        while time.process_time() < end:
            pass
        return state(cell)

    monkeypatch.setattr(EmptyCell, "state", costly)
    (tmp_path / "solution.py").write_text(ASKS)
    sandbox = choose(insecure=all(kind().missing() for kind in KINDS))
    ending, _ = run_in(sandbox, tmp_path / "solution.py", tmp_path / "run", replace(QUICK, answers_s=0.2))
    assert (ending.reason, ending.message[:40]) == ("answers", "pictures and refusals took the server ov")
