"""`tamp perceive` as a user calls it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tamp.cli.command_line import main
from tamp.perception.estimate import Estimate

pytest.importorskip("embreex", reason="the extra perception is not installed")

TASK = """name: one
robot: panda
objects:
  - {name: brick, shape: {box: [0.16, 0.09, 0.05]}, pose: {xyz: [-0.05, 0.12, 0.026]}}
"""


SETUP = """cameras:
  - {name: top, parent: world, pose: {xyz: [0, 0, 1], quat: [1, 0, 0, 0]}, size: [1, 1], field_of_view: 0.8}
"""


def test_poses_are_written_and_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "one.yaml").write_text(TASK, encoding="utf-8")
    assert main(["perceive", str(tmp_path / "one.yaml"), "-o", str(tmp_path / "poses.json")]) == 0
    assert "cm off, confidence" in capsys.readouterr().out
    assert set(json.loads((tmp_path / "poses.json").read_text(encoding="utf-8"))) == {"brick"}


def raising(frames: Any, objects: Any, *, table: Any, seed: int) -> Any:
    raise KeyError("brick")


def renaming(frames: Any, objects: Any, *, table: Any, seed: int) -> Any:
    return {"spoon": Estimate(None, 0.0)}


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--perceiver", "eyes"], "unknown perceiver 'eyes'; valid are fit and package.module:function"),
        (["--setup", "nowhere.yaml"], "nowhere.yaml"),
        (["--setup", "one_pixel.yaml", "--perceiver", f"{__name__}:raising"], "raising raised KeyError: 'brick' at "),
        (["--setup", "one_pixel.yaml", "--perceiver", f"{__name__}:renaming"], "names ['spoon']; asked for were"),
    ],
)
def test_bad_input_is_one_sentence(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    option: list[str],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.yaml").write_text(TASK, encoding="utf-8")
    (tmp_path / "one_pixel.yaml").write_text(SETUP, encoding="utf-8")
    assert main(["perceive", str(tmp_path / "one.yaml"), *option]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
