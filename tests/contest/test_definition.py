"""What a module's source is refused for before anything of it is run, and what is left for a run to tell."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tamp.contest import definition, samples
from tamp.contest.definition import LACKING, lacking, objection

RUN = "    def run(self, goal, robot): ...\n"
MAY = {
    "class": f"class Solution:\n{RUN}",
    "agent": "class MyAgent:\n    def draw_action(self, observation): ...",
    "agent called Solution": "class Solution:\n    def draw_action(self, observation): ...",
    "import": "from mine import Solution",
    "renamed": "import mine as Solution",
    "star": "from mine import *",
    "assigned": "Solution = make()",
    "either": f"try:\n    from mine import Solution\nexcept ImportError:\n    class Solution:\n    {RUN}",
    "conditional": "if True:\n    class Solution:\n        run = print",
    "inherited": "class Solution(Base): ...",
    "metaclass": "class Solution(metaclass=Meta): ...",
    "decorated": "@made\nclass Solution: ...",
    "set later": "class Solution: ...\nSolution.run = print",
    "executed": "exec(text)",
    "global": "def make():\n    global Solution\n    class Solution: ...",
    "by name": "setattr(sys.modules[__name__], 'Solution', made)",
    "module getattr": "def __getattr__(name): ...",
    "walrus": "print(Solution := made)",
    "too deep to tell": "-" * 300_000 + "1",
}
MUST_NOT = {
    "nothing": "",
    "function": "def solve(goal, robot): ...",
    "small": f"class solution:\n{RUN}",
    "no run": "class Solution:\n    def go(self): ...",
    "agent without": f"class MyAgent:\n{RUN}",
    "in a function": f"def make():\n    class Solution:\n    {RUN}",
    "in words": "# class Solution:\nprint('class Solution')",
}


@pytest.mark.parametrize("which", MAY)
def test_what_may_define_a_solution_is_not_objected_to(tmp_path: Path, which: str) -> None:
    (tmp_path / "a.py").write_text(MAY[which])
    assert objection(tmp_path / "a.py") == ""


@pytest.mark.parametrize("which", MUST_NOT)
def test_what_cannot_is(which: str) -> None:
    assert lacking(MUST_NOT[which].encode()) == LACKING


@pytest.mark.parametrize(
    ("code", "why"),
    [
        (b"x = (", "line 1: "),
        (b"\nreturn 3", "line 2: 'return' outside function"),
        (b"x = '\xe4'", "utf-8"),
        (b"\0", "null bytes"),
        (b"# coding: nonsense\n", "unknown encoding: nonsense"),
    ],
)
def test_what_python_cannot_read_is_told(tmp_path: Path, code: bytes, why: str) -> None:
    (tmp_path / "a.py").write_bytes(code)
    assert re.match("is no Python", said := objection(tmp_path / "a.py")) and why in said and "None" not in said


def test_samples_and_hostile_solutions_are_let_through_to_their_runs() -> None:
    folders = [Path(samples.__file__).parent, Path(__file__).parent / "hostile"]
    files = [file for folder in folders for file in folder.glob("*.py") if file.name != "__init__.py"]
    assert len(files) > 40 and not [file.name for file in files if lacking(file.read_bytes())]


def test_nothing_of_it_is_run(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(f"import pathlib\npathlib.Path({str(tmp_path / 'ran')!r}).touch()\nprint('x')")
    assert objection(tmp_path / "a.py") == LACKING and not (tmp_path / "ran").exists()
    (tmp_path / "a.py").rename(tmp_path / "__init__.py")
    assert objection(tmp_path / "__init__.py") == f"{LACKING}; import it there from where it is"


def test_where_what_is_read_ends_the_interpreter_no_program_for_core_files_is_started(tmp_path: Path) -> None:
    """That program runs as root, and outside of all limits, where a machine has one; by a limit of 1 there is none."""
    os.mkfifo(tmp_path / "a.py")
    command = [sys.executable, "-I", "-S", definition.__file__, str(tmp_path / "a.py")]
    with subprocess.Popen(command) as reader, (tmp_path / "a.py").open("wb"):  # it reads now, and until this is closed
        limits = Path(f"/proc/{reader.pid}/limits").read_text()
    assert re.search(r"Max core file size +1 ", limits)
