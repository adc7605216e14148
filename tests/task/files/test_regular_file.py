"""What is no regular file is refused at once: nobody waits for a pipe, or reads a device without end."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tamp.errors import PlanError, RobotError, TaskError
from tamp.task.files.plan_file import load_plan
from tamp.task.files.poses_file import load_poses
from tamp.task.files.regular_file import read_regular
from tamp.task.files.robot.urdf_file import _parse
from tamp.task.files.yaml_document import read_document


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe")
    return folder / "pipe"


def device(folder: Path) -> Path:
    (folder / "zero").symlink_to("/dev/zero")
    return folder / "zero"


@pytest.mark.parametrize("make", [pipe, device])
@pytest.mark.parametrize("read", [load_plan, read_document, load_poses, _parse])
def test_a_pipe_and_a_device_are_no_files(tmp_path, make, read):
    with pytest.raises((PlanError, TaskError, RobotError), match="no regular file"):
        read(make(tmp_path))


def test_no_more_is_read_than_there_may_be(tmp_path):
    (tmp_path / "file").write_bytes(b"12345")
    assert read_regular(tmp_path / "file", 5) == b"12345"
    with pytest.raises(OSError, match="larger than 4 bytes"):
        read_regular(tmp_path / "file", 4)
