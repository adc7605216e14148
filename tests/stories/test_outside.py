"""Domain, skill, robot and sampler in a folder of one's own, as the manual has them: its tutorials' files, its page of
samplers, and the three variables of its page on outside folders. Nothing of it lies on Python's path."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.manual import ROOT, cells, files

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


def written_by(tutorial: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the cells of a tutorial that write files do so in a folder."""
    folder.mkdir(parents=True)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", list(sys.path))
    namespace: dict[str, object] = {}
    for cell in cells(ROOT / "docs" / "tutorials" / f"{tutorial}.ipynb"):
        source = "".join(cell["source"])
        if "mkdir(" in source or "write_text(" in source:
            exec(source.partition("judgement =")[0], namespace)


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that the manual calls my-lab."""
    root = tmp_path / "my-lab"
    written_by("own_skill", root / "domains", monkeypatch)
    written_by("own_robot", root / "robots", monkeypatch)
    (root / "samplers").mkdir()
    for name, text in files(ROOT / "docs" / "guides" / "samplers.md", "python").items():
        (root / "samplers" / name).write_text(text, encoding="utf-8")
    return root


def test_a_lab_of_ones_own_works_by_names_alone(lab: Path, tmp_path: Path) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    (empty / "ring.yaml").write_text(TASK, encoding="utf-8")
    named = {f"TAMP_{kind.upper()}": str(lab / kind) for kind in ("domains", "robots", "samplers")}

    def tamp(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "tamp", *words],
            capture_output=True,
            text=True,
            cwd=empty,
            env={**os.environ, **named},
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    assert "buttons" in tamp("domains")
    assert "small" in tamp("robots")
    mine = ["--sampler", "sample-grasp=my_grasps:from_above"]
    (result,) = json.loads(tamp("solve", "ring.yaml", *mine, "--clock", "processor", "--output", "runs", "--json", "-"))
    assert (result["status"], result["domain"], result["plan_checked"]) == ("solved", "buttons", True)
    assert result["goals_met"] == {"block": True, "(pressed bell)": True}
    tamp("report", "runs")
    assert "press bell" in (empty / "runs" / "report.html").read_text(encoding="utf-8")
