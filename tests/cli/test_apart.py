"""Whatever a command does to its process, the one that waits for it ends in time, and takes nothing for a success."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

HERE = Path(__file__).parents[2]
ENDED = "tamp: a sampler ended the program\n"


def carried_out(name: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tests.cli.hostile_commands", name]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=20, cwd=folder, env={"PYTHONPATH": str(HERE)}
    )


@pytest.mark.parametrize(
    ("name", "status", "said"),
    [
        ("writes_into_every_pipe", 2, ENDED),
        ("closes_every_descriptor", 2, ENDED),
        ("fails_and_ends_well", 1, ""),
        ("exits_well", 1, ""),
    ],
)
def test_what_ends_the_process_is_no_success(tmp_path: Path, name: str, status: int, said: str) -> None:
    done = carried_out(name, tmp_path)
    assert (done.returncode, done.stderr) == (status, said)
    opened = tmp_path / "opened"
    assert not opened.exists() or not opened.read_text(), "nobody writes into what is not the pipe any more"


def test_a_copy_of_the_process_does_not_speak_for_it(tmp_path: Path) -> None:
    done = carried_out("forks_one_that_comes_to_an_end", tmp_path)
    assert (done.returncode, done.stderr.endswith(ENDED)) == (2, True)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="orphans are adopted on Linux")
@pytest.mark.parametrize(
    ("name", "status", "said"), [("leaves_a_session_behind", 0, ""), ("goes_on_in_another_group", 1, "it is late\n")]
)
def test_what_is_left_behind_is_ended(tmp_path: Path, name: str, status: int, said: str) -> None:
    began = time.monotonic()
    done = carried_out(name, tmp_path)  # waits for all that hold its output
    assert (done.returncode, done.stderr) == (status, said)
    assert time.monotonic() - began < 15.0
    assert not Path(f"/proc/{int(done.stdout)}").exists()


def test_what_a_shell_has_begun_before_goes_on(tmp_path: Path) -> None:
    """A shell that begins something, and then becomes this process, leaves it a child that is not the command's."""
    script = f"sleep 30 & echo $!; exec {sys.executable} -m tests.cli.hostile_commands comes_to_an_end"
    with subprocess.Popen(
        ["sh", "-c", script], stdout=subprocess.PIPE, text=True, cwd=tmp_path, env={"PYTHONPATH": str(HERE)}
    ) as shell:
        assert shell.stdout is not None
        begun = int(shell.stdout.readline())
        try:
            assert shell.wait(timeout=20) == 0
            os.kill(begun, 0)
        finally:
            os.kill(begun, signal.SIGKILL)
