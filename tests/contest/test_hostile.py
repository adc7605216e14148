"""Every hostile solution is stopped and named, whatever the machine isolates with, and leaves nothing behind."""

from __future__ import annotations

import ast
import os
import re
import socket
import threading
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from tamp.contest.evaluation.trial import cannot_load
from tamp.contest.package import Package
from tamp.contest.rules import Rules
from tamp.contest.sandbox import cgroups
from tamp.contest.sandbox.bubblewrap import Bubblewrap
from tamp.contest.sandbox.isolation import Room, Sandbox
from tamp.contest.sandbox.namespaces import Namespaces
from tamp.contest.sandbox.plain import Plain
from tamp.contest.sandbox.process import SandboxedProcess
from tamp.contest.sandbox.reaper import children
from tamp.errors import TampError
from tests.contest.cells import QUICK, run_in

TIGHTER = {name: {"idle_s": 1.5} for name in ("sleeps", "never_reads", "slow_frame")}
TIGHTER |= {"stands_still": {"idle_s": 0.6}}
TIGHTER |= {name: {"processor_s": 1.0} for name in ("burns_processor", "hidden_processor")}
"""Solutions that would use up a whole limit -> a smaller one."""

LIMITED = ("burns_processor", "eats_memory", "many_eat_memory", "endless_output", "sleeps", "never_reads", "huge_frame")
LIMITED += ("huge_header", "deep_json", "lies", "invents_calls", "slow_frame", "closes_socket", "leaves_unsaid")
LIMITED += (
    "come_and_go",
    "fills_sockets",
    "hides_sockets",
    "many_mappings",
    "page_tables",
    "odd_names",
    "prints_slowly",
    "impossible_array",
)
LIMITED += ("escapes_terminal", "raises_in_words", "half_characters", "far_away", "begins_again", "hidden_processor")
LIMITED += ("fills_pipes", "leaves_in_backlog", "stands_still", "lies_about_time")
"""Solutions that limits and protocol stop, whatever the walls are made of: one sandbox is enough."""

HOSTILE = sorted(path for path in (Path(__file__).parent / "hostile").glob("*.py") if path.stem != "__init__")


@pytest.fixture(params=[Namespaces, Bubblewrap], ids=lambda kind: kind.name, scope="module")
def sandbox(request: pytest.FixtureRequest) -> Sandbox:
    made: Sandbox = request.param()
    why_not = made.missing()
    if why_not:
        pytest.skip(f"this machine has no {made.name}: {why_not}")
    return made


def _expected(path: Path) -> list[tuple[str, str]]:
    """Each reason that may stop a solution, and a part of the message that says so."""
    text = ast.get_docstring(ast.parse(path.read_text())) or ""
    pairs = [way.partition(":") for way in text.split("|")]
    return [(reason.strip(), message.strip()) for reason, _, message in pairs]


@pytest.mark.parametrize("path", HOSTILE, ids=lambda path: path.stem)
def test_is_stopped_and_named(path: Path, sandbox: Sandbox, tmp_path: Path) -> None:
    if path.stem in LIMITED and sandbox.name != "namespaces" and not Namespaces().missing():
        pytest.skip("the limits are the same in every sandbox, and were tried in another")
    before = set(children(os.getpid()))
    ending, output = run_in(sandbox, path, tmp_path, replace(QUICK, **TIGHTER.get(path.stem, {})))
    assert any(ending.reason == reason and part in ending.message for reason, part in _expected(path)), (ending, output)
    assert set(children(os.getpid())) <= before
    assert len(output) <= 64 << 10
    assert ending.message.isprintable(), "what a solution says goes to terminals and pages"


@pytest.mark.parametrize(
    "name",
    ["come_and_go", "fills_sockets", "hides_sockets", "leaves_in_backlog", "many_mappings", "page_tables", "odd_names"],
)
def test_memory_is_seen_without_control_groups(
    name: str, sandbox: Sandbox, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if sandbox.name != "namespaces" and not Namespaces().missing():
        pytest.skip("processes are looked at in the same way in every sandbox")
    monkeypatch.setattr(cgroups, "make", lambda _: None)
    limits = replace(QUICK, wall_s=20.0)
    ending, output = run_in(sandbox, Path(__file__).parent / "hostile" / f"{name}.py", tmp_path, limits)
    assert ending.reason == "memory", (ending, output)


def test_modules_of_its_own_take_no_place_of_others(sandbox: Sandbox, tmp_path: Path) -> None:
    """A package may hold what is called as libraries are, as the API, and as what Python runs at its start."""
    code = "raise RuntimeError('was imported')\n"
    names = ("numpy/__init__.py", "tamp/__init__.py", "json.py", "sitecustomize.py", "usercustomize.py", "setup.py")
    with zipfile.ZipFile(tmp_path / "own.zip", "w") as archive:
        for name in names:
            archive.writestr(name, code)
        archive.writestr("own.pth", f"import os; {code}")
        archive.writestr("own-1.0.dist-info/entry_points.txt", "[console_scripts]\npython = setup:main\n")
        archive.writestr(
            "solution.py",
            "import json, numpy, tamp.contest.api.client\n\nclass Solution:\n    def run(self, goal, robot):\n"
            "        assert numpy.__file__.startswith('/site/'), numpy.__file__\n        robot.arm.state()\n",
        )
    ending, output = run_in(sandbox, tmp_path / "own.zip", tmp_path / "run")
    assert ending.reason == "finished", output


def test_a_solution_that_is_called_as_a_library_is_told_so(sandbox: Sandbox, tmp_path: Path) -> None:
    (tmp_path / "numpy.py").write_text("class Solution:\n    def run(self, goal, robot): ...\n")
    with zipfile.ZipFile(tmp_path / "own.zip", "w") as archive:
        archive.write(tmp_path / "numpy.py", "numpy.py")
    ending, _ = run_in(sandbox, tmp_path / "own.zip", tmp_path / "run")
    assert ending.reason == "raised"
    assert "another module is called 'numpy'; call it 'solution'" in ending.message


@pytest.mark.parametrize("run", ["async def run(self, goal, robot): ...", "def run(self, goal, robot): yield"])
def test_what_would_not_run_is_told_so(run: str, sandbox: Sandbox, tmp_path: Path) -> None:
    (tmp_path / "solution.py").write_text(f"class Solution:\n    {run}\n")
    ending, _ = run_in(sandbox, tmp_path / "solution.py", tmp_path / "run")
    assert "Solution.run is a coroutine or a generator" in ending.message


def test_may_wait_for_several_things_and_lock_whole_files(sandbox: Sandbox, tmp_path: Path) -> None:
    """What libraries do: where `epoll` is refused, Python waits by `poll`."""
    (tmp_path / "solution.py").write_text(
        "import asyncio, fcntl, subprocess, sys\n\nasync def both():\n"
        "    return await asyncio.gather(asyncio.sleep(0.01, 1), asyncio.to_thread(lambda: 2))\n\n"
        "class Solution:\n    def run(self, goal, robot):\n"
        "        assert asyncio.run(both()) == [1, 2]\n"
        "        fcntl.flock(open('/tmp/file', 'w'), fcntl.LOCK_EX)\n"
        "        assert subprocess.run(['true'], capture_output=True).returncode == 0\n"
    )
    ending, output = run_in(sandbox, tmp_path / "solution.py", tmp_path / "run")
    assert ending.reason == "finished", output


ORDINARY = """
import argparse, concurrent.futures, getpass, multiprocessing, os, socket, subprocess, sys
from multiprocessing.shared_memory import SharedMemory

def square(number):
    return number * number

class Solution:
    def run(self, goal, robot):
        argparse.ArgumentParser().parse_args()
        with concurrent.futures.ProcessPoolExecutor(2) as pool:
            assert list(pool.map(square, [2, 3])) == [4, 9]
        shared, lock = SharedMemory(create=True, size=9), multiprocessing.Lock()
        shared.close()
        shared.unlink()
        assert os.path.realpath("/dev/shm") == "/tmp"  # it counts as its other files do
        open("/dev/stdout", "w").write(getpass.getuser())
        code = "import numpy, other; print(numpy.__file__)"
        for options in ([], subprocess._args_from_interpreter_flags()):  # as joblib's processes have them
            command = [sys.executable, *options, "-c", code]
            found = subprocess.run(command, capture_output=True, text=True, check=True)
            assert found.stdout.startswith("/site/"), found
        assert not hasattr(socket.socket, "sendmsg")
        assert "forkserver" not in multiprocessing.get_all_start_methods()
"""


def test_may_use_what_python_and_libraries_are_used_with(sandbox: Sandbox, tmp_path: Path) -> None:
    """Pools of processes, shared memory, arguments, Pythons of its own; of Python from 3.12 on asyncio's writing."""
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "solution.py").write_text(ORDINARY)
    (folder / "other.py").write_text("")
    ending, output = run_in(sandbox, folder, tmp_path / "run")
    assert ending.reason == "finished", output
    assert output == b"solution"


def test_what_meets_the_sandboxs_end_is_told_so(sandbox: Sandbox, tmp_path: Path) -> None:
    if sandbox.name != "namespaces" and not Namespaces().missing():
        pytest.skip("the same in every sandbox, and tried in another")
    (tmp_path / "solution.py").write_text("import socket\n\nsocket.create_server(('127.0.0.1', 0))\n")
    ending, _ = run_in(sandbox, tmp_path / "solution.py", tmp_path / "run")
    assert ending.message.startswith("PermissionError: [Errno 1] Operation not permitted; the sandbox has no network")


def test_reaches_no_socket_without_a_path(sandbox: Sandbox, tmp_path: Path) -> None:
    name = f"tamp-test-hostile-{os.getpid()}"  # tests of another process may listen at the same time
    (tmp_path / "solution.py").write_text(
        "import socket\n\nclass Solution:\n    def run(self, goal, robot):\n"
        f"        socket.socket(socket.AF_UNIX).connect('\\0{name}')\n"
    )
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(f"\0{name}")
        server.listen()
        ending, _ = run_in(sandbox, tmp_path / "solution.py", tmp_path / "run")
    assert "ConnectionRefusedError" in ending.message


def test_reaches_no_server_on_this_machine(sandbox: Sandbox, tmp_path: Path) -> None:
    source = (Path(__file__).parent / "hostile" / "opens_socket.py").read_text()
    with socket.create_server(("127.0.0.1", 0)) as server:
        reached = threading.Event()
        thread = threading.Thread(target=lambda: (server.accept(), reached.set()), daemon=True)
        thread.start()
        solution = tmp_path / "solution.py"
        solution.write_text(re.sub(r"PORT = \d+", f"PORT = {server.getsockname()[1]}", source))
        ending, _ = run_in(sandbox, solution, tmp_path / "run")
        assert ending.reason == "raised"
        assert not reached.is_set()


def test_a_process_that_ends_while_it_is_looked_at_has_no_children(monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(*_: object) -> None:
        raise ProcessLookupError

    with monkeypatch.context() as patch:
        patch.setattr(os, "scandir", gone)
        patch.setattr(Path, "iterdir", gone)
        assert children(os.getpid()) == []


def test_nothing_runs_that_nobody_watches(sandbox: Sandbox, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is ended, and not charged for that: its run is done anew."""

    def fails(_: SandboxedProcess) -> None:
        raise RuntimeError("no more handles")

    monkeypatch.setattr(SandboxedProcess, "_look", fails)
    with pytest.raises(TampError, match="a solution could not be watched: RuntimeError: no more handles"):
        run_in(sandbox, Path(__file__).parent / "hostile" / "sleeps.py", tmp_path)


def test_one_runs_group_is_not_removed_by_another() -> None:
    first = cgroups.make(QUICK)
    if first is None:
        pytest.skip("this user may not make control groups")
    second = cgroups.make(QUICK)
    assert second is not None
    try:
        assert first.memory.exists() and second.pids.exists()
    finally:
        first.remove()
        second.remove()
    assert not first.memory.exists()


def test_a_library_that_is_not_there_is_told_with_what_there_is_and_how_to_bring_one(
    sandbox: Sandbox, tmp_path: Path
) -> None:
    solution = tmp_path / "solution.py"
    solution.write_text("import nowhere.to_be_found\n\nclass Solution:\n    def run(self, goal, robot): ...\n")
    ending, _ = run_in(sandbox, solution, tmp_path / "run")
    assert ending.message.startswith("ModuleNotFoundError: No module named 'nowhere'; a solution may import")
    assert "numpy and what its package brings: put the library into the .zip" in ending.message
    folder = tmp_path / "own"
    (folder / "solution").mkdir(parents=True)
    (folder / "solution" / "__init__.py").write_text("import solution.picks\n")
    ending, _ = run_in(sandbox, folder, tmp_path / "again")
    assert ending.message == "ModuleNotFoundError: No module named 'solution.picks'"
    solution.write_text("from .picks import pick\n")
    ending, _ = run_in(sandbox, solution, tmp_path / "beside")
    assert "; a module beside solution.py is imported by its name alone: 'import helpers'" in ending.message
    (folder / "solution" / "__init__.py").write_text("")
    ending, _ = run_in(sandbox, folder, tmp_path / "empty")
    assert ending.message.endswith("draw_action(self, observation); import it in the package's __init__.py")
    (folder / "solution" / "__init__.py").write_text("open('weights.bin')\n")
    (folder / "weights.bin").write_text("")
    ending, _ = run_in(sandbox, folder, tmp_path / "file")
    assert ending.message.endswith("a package's files are beside its module: Path(__file__).parent / 'weights.bin'")


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("raise RuntimeError('a\\nb')\n", "RuntimeError: a b"),
        ("class Solution:\n    def run(self, goal, robot): raise RuntimeError\n", ""),
        (
            "class Solution:\n    def run(self, goal): ...\n",
            "TypeError: Solution.run is called with goal and robot: too many positional arguments",
        ),
        ("class Solution:\n    def run(self, *everything, **named): ...\n", ""),
        ("import os\nos._exit(255)\n", "the process ended with status 255 before Solution() was made"),
        ("import sys\nsys.exit()\n", "SystemExit"),
        (
            "import ctypes\nctypes.string_at(0)\n",
            "the process was ended by signal 11 (Segmentation fault) before Solution() was made",
        ),
        ("while True: print('here')\n", "printed more than 64 KiB"),
    ],
)
def test_what_cannot_be_loaded_says_so_without_a_task(code: str, said: str, sandbox: Sandbox, tmp_path: Path) -> None:
    if sandbox.name != "namespaces" and not Namespaces().missing():
        pytest.skip("the same in every sandbox, and tried in another")
    (tmp_path / "solution.py").write_text(code)
    assert cannot_load(Package(tmp_path, "solution"), Rules(limits=QUICK), sandbox)[0] == said


def test_a_sandbox_that_does_not_begin_is_no_fault_of_the_solution(tmp_path: Path) -> None:
    class Broken(Plain):
        def command(self, room: Room, command: Sequence[str]) -> list[str]:
            return ["/bin/sh", "-c", "echo no namespaces; exit 1"]

    (tmp_path / "solution.py").write_text("raise RuntimeError\n")
    assert cannot_load(Package(tmp_path, "solution"), Rules(limits=QUICK), Broken()) == ("", b"")


def test_what_was_printed_before_a_run_is_stopped_is_read_in_its_order(sandbox: Sandbox, tmp_path: Path) -> None:
    (tmp_path / "solution.py").write_text(
        "import os, sys\n\nclass Solution:\n    def run(self, goal, robot):\n"
        "        print('one')\n        print('two', file=sys.stderr)\n        print('three')\n        os._exit(3)\n"
    )
    ending, output = run_in(sandbox, tmp_path / "solution.py", tmp_path / "run")
    assert ending.reason == "died"
    assert output.decode().split() == ["one", "two", "three"]


@pytest.mark.parametrize(
    "close", ["sys.stdout.close(); sys.stderr.close()", "sys.stderr = sys.stdout = 3", "os.closerange(0, 3)"]
)
@pytest.mark.parametrize(("last", "reason"), [("", "finished"), ("raise KeyError(5)", "raised")])
def test_who_closes_what_is_printed_to_ends_as_others_do(
    close: str, last: str, reason: str, sandbox: Sandbox, tmp_path: Path
) -> None:
    (tmp_path / "solution.py").write_text(
        "import os, sys\n\nclass Solution:\n    def run(self, goal, robot):\n"
        f"        print('x', end=''); {close}\n        {last}\n"
    )
    assert run_in(sandbox, tmp_path / "solution.py", tmp_path / "run")[0].reason == reason
