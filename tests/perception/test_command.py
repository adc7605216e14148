"""`tamp perceive` as a user calls it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tamp.cli.command_line import main

pytest.importorskip("embreex", reason="the extra perception is not installed")

TASK = """name: one
robot: panda
objects:
  - {name: brick, shape: {box: [0.16, 0.09, 0.05]}, pose: {xyz: [-0.05, 0.12, 0.026]}}
"""


def test_poses_are_written_and_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "one.yaml").write_text(TASK, encoding="utf-8")
    assert main(["perceive", str(tmp_path / "one.yaml"), "-o", str(tmp_path / "poses.json")]) == 0
    assert "cm off, confidence" in capsys.readouterr().out
    assert set(json.loads((tmp_path / "poses.json").read_text(encoding="utf-8"))) == {"brick"}


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--perceiver", "eyes"], "unknown perceiver 'eyes'; valid are fit and package.module:function"),
        (["--setup", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_bad_input_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], option: list[str], said: str
) -> None:
    (tmp_path / "one.yaml").write_text(TASK, encoding="utf-8")
    assert main(["perceive", str(tmp_path / "one.yaml"), *option]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
