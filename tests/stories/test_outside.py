"""Domain, skill, robot and sampler in a folder of one's own, as the manual has them: its tutorials' files, its page of
samplers, and the three variables of its page on outside folders. Nothing of it lies on Python's path. Besides a skill
that no page has, written with nothing but what they say: what is in the hand is shaken."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.manual import ROOT, files, undocumented, write_files_of

SHAKING = Path(__file__).parent / "lab" / "shaking"

TASK = """
domain: buttons
robot: small
objects:
  - {name: block, shape: {box: [0.04, 0.04, 0.06]}, pose: {xyz: [0.05, 0.1, 0.03]},
     goal: {pose: {xyz: [0.0, -0.15, 0.03]}}}
regions: [{name: bell, box: {center: [0.0, -0.05], size: [0.06, 0.06]}}]
init: [[Button, bell]]
goal: [[Pressed, bell]]
"""

MIX = """
domain: shaking
robot: small
objects:
  - {name: bottle, shape: {cylinder: {radius: 0.022, height: 0.1}}, pose: {xyz: [0.0, 0.12, 0.05]},
     goal: {pose: {xyz: [0.05, -0.15, 0.05]}}}
  - {name: block, shape: {box: [0.04, 0.04, 0.06]}, pose: {xyz: [0.08, 0.0, 0.03]}}
init: [[Shakeable, bottle]]
goal: [[Shaken, bottle]]
"""


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """The folder that the manual calls my-lab."""
    root = tmp_path / "my-lab"
    write_files_of("own_skill", root / "domains")
    write_files_of("own_robot", root / "robots")
    shutil.copytree(SHAKING, root / "domains" / "shaking")
    (root / "samplers").mkdir()
    for name, text in files(ROOT / "docs" / "guides" / "samplers.md", "python").items():
        (root / "samplers" / name).write_text(text, encoding="utf-8")
    return root


class Shell:
    """Commands as somebody gives them in an empty folder, with the three variables set."""

    def __init__(self, lab: Path, folder: Path) -> None:
        self.folder = folder
        self._named = {f"TAMP_{kind.upper()}": str(lab / kind) for kind in ("domains", "robots", "samplers")}
        folder.mkdir()

    def tamp(self, *words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "tamp", *words],
            capture_output=True,
            text=True,
            cwd=self.folder,
            env={**os.environ, **self._named},
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout


@pytest.fixture
def shell(lab: Path, tmp_path: Path) -> Shell:
    return Shell(lab, tmp_path / "empty")


def test_a_lab_of_ones_own_works_by_names_alone(shell: Shell) -> None:
    (shell.folder / "ring.yaml").write_text(TASK, encoding="utf-8")
    assert "buttons" in shell.tamp("domains")
    assert "small" in shell.tamp("robots")
    mine = ["--sampler", "sample-grasp=my_grasps:from_above", "--clock", "processor", "--output", "runs", "--json", "-"]
    (result,) = json.loads(shell.tamp("solve", "ring.yaml", *mine))
    assert (result["status"], result["domain"], result["plan_checked"]) == ("solved", "buttons", True)
    assert result["goals_met"] == {"block": True, "(pressed bell)": True}
    shell.tamp("report", "runs")
    assert "press bell" in (shell.folder / "runs" / "report.html").read_text(encoding="utf-8")


def test_a_skill_that_no_page_has_is_written_from_the_manual(shell: Shell) -> None:
    assert {file.name: undocumented(file) for file in SHAKING.glob("*.py") if undocumented(file)} == {}
    (shell.folder / "mix.yaml").write_text(MIX, encoding="utf-8")
    check = ["samplers", "check", "shaking.sampler:plan_shake", "--stream", "plan-shake", "--domain", "shaking"]
    assert "it fits" in shell.tamp(*check, "--task", "mix.yaml")
    (result,) = json.loads(shell.tamp("solve", "mix.yaml", "--clock", "processor", "--json", "-"))
    assert (result["status"], result["plan_checked"]) == ("solved", True)
    assert result["goals_met"] == {"bottle": True, "(shaken bottle)": True}
