"""`tamp dataset` as a user calls it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamp.cli.command_line import main

pytest.importorskip("embreex", reason="the extra perception is not installed")

TASK = """name: one
robot: panda
objects:
  - {name: brick, shape: {box: [0.16, 0.09, 0.05]}, pose: {xyz: [-0.05, 0.12, 0.026]}}
"""


def _made(tmp_path: Path, *more: str) -> int:
    (tmp_path / "one.yaml").write_text(TASK, encoding="utf-8")
    return main(["dataset", str(tmp_path / "one.yaml"), "-o", str(tmp_path / "set"), "--objects", "1", *more])


def test_scenes_are_written_once_and_a_run_is_resumed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _made(tmp_path, "-n", "1", "--views", "1", "--format", "ocrtoc") == 0
    scene = tmp_path / "set" / "scenes" / "000000"
    before = (scene / "rgb_undistort" / "0000.png").stat().st_mtime_ns
    capsys.readouterr()
    assert _made(tmp_path, "-n", "1", "--views", "1", "--format", "ocrtoc") == 0
    assert "1 scenes (1 of them were there), 1 pictures" in capsys.readouterr().out
    assert (scene / "rgb_undistort" / "0000.png").stat().st_mtime_ns == before
    assert _made(tmp_path, "-n", "1", "--views", "2", "--format", "ocrtoc") == 2
    assert "made with other views; give another --output" in capsys.readouterr().err


def test_a_folder_of_something_else_is_refused_and_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    theirs = tmp_path / "set" / "models" / "obj_000001.ply"
    theirs.parent.mkdir(parents=True)
    theirs.write_text("theirs", encoding="utf-8")
    assert _made(tmp_path, "-n", "1", "--views", "1") == 2
    assert "set holds something else than a data set of this command; give another --output" in capsys.readouterr().err
    assert [path for path in (tmp_path / "set").rglob("*") if path.is_file()] == [theirs]
    assert theirs.read_text(encoding="utf-8") == "theirs"


def test_more_objects_than_the_tasks_have_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _made(tmp_path, "-n", "1", "--views", "1", "--objects", "7") == 2
    assert "--objects 7: the tasks have 1 objects of different shapes" in capsys.readouterr().err
    assert not (tmp_path / "set").exists()
