"""Which robots there are: by name, by path, of the user's folders, of a task's; and where a task's robot stands."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from tamp.errors import RobotError, TaskError
from tamp.task import Pose, load_robot, robot_names, task_robot
from tamp.task.files.load import load_task
from tamp.task.files.save import save_task
from tamp.task.robots import VARIABLE, with_robot
from tests.task.swinging import write

TASK = """
robot: {robot}
objects:
  - {{name: red, shape: {{box: [0.05, 0.05, 0.08]}}, pose: {{xyz: [0.1, 0.2, 0.04]}}}}
"""


def test_robots_of_the_users_folders_have_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "swinging")
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    assert {"panda", "swinging"} <= {*robot_names()}
    assert load_robot("swinging").name == "swinging"
    assert load_robot("swinging") is load_robot(str(tmp_path / "swinging"))


def test_two_robots_of_one_name_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "panda")
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    with pytest.raises(RobotError, match="robot 'panda' is there twice"):
        robot_names()


def test_a_folder_that_is_none_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "absent"))
    with pytest.raises(RobotError, match=f"{VARIABLE} names .*absent, which is no folder"):
        robot_names()


def test_an_unknown_robot_is_told_what_there_is() -> None:
    with pytest.raises(
        RobotError, match=r"'pander'; did you mean 'panda'\? there are panda, .*the path of a robot\.yaml"
    ):
        load_robot("pander")


def test_a_robot_that_changes_on_disk_is_read_again(tmp_path: Path) -> None:
    path = write(tmp_path / "swinging")
    assert load_robot(str(path)).gripper.force == 20.0
    path.write_text(path.read_text().replace("force: 20.0", "force: 25.0"))
    path.touch()
    assert load_robot(str(path)).gripper.force == 25.0


def test_a_task_s_path_is_relative_to_its_file_wherever_it_is_saved(tmp_path: Path) -> None:
    write(tmp_path / "arms" / "swinging")
    file = tmp_path / "task.yaml"
    file.write_text(TASK.format(robot="arms/swinging/robot.yaml"))
    task = load_task(file)
    assert task.robot == "arms/swinging/robot.yaml" and task_robot(task).name == "swinging"
    (tmp_path / "elsewhere").mkdir()
    save_task(task, tmp_path / "elsewhere" / "task.yaml")
    again = load_task(tmp_path / "elsewhere" / "task.yaml", allow_outside=True)
    assert again.robot == "../arms/swinging/robot.yaml" and task_robot(again) == task_robot(task)
    with pytest.raises(TaskError, match=r"robot: .* lies outside the task's folder; .* --allow-outside"):
        load_task(tmp_path / "elsewhere" / "task.yaml")


def test_a_task_s_robot_that_is_not_there_is_named_with_the_line(tmp_path: Path) -> None:
    file = tmp_path / "task.yaml"
    file.write_text(TASK.format(robot="arms/absent/robot.yaml"))
    with pytest.raises(TaskError, match=r"task\.yaml:2: robot: there is no file arms/absent/robot\.yaml"):
        load_task(file)


def test_the_base_stands_where_the_task_says(tmp_path: Path) -> None:
    file = tmp_path / "task.yaml"
    file.write_text(TASK.format(robot="panda") + "base: {xyz: [-0.5, 0.1, 0.0], rpy: [0.0, 0.0, 0.5]}\n")
    task = load_task(file)
    assert task_robot(task).T_world_base == task.base == Pose.from_rpy((-0.5, 0.1, 0.0), (0.0, 0.0, 0.5))
    save_task(task, file)
    assert load_task(file).base == task.base


def test_the_arm_starts_from_where_the_task_says(tmp_path: Path) -> None:
    file, told = tmp_path / "task.yaml", "home: [0.1, -0.2, 0, -1.5, 0, 1.6, 0.8]\n"
    file.write_text(TASK.format(robot="panda") + told)
    task = load_task(file)
    assert task_robot(task).home == task.home == (0.1, -0.2, 0.0, -1.5, 0.0, 1.6, 0.8)
    save_task(task, file)
    assert load_task(file).home == task.home
    assert with_robot(task, "panda").home is None
    for wrong, complaint in (
        ("[0.1, 0.2]", "has 2 joints, but .* has 7"),
        (told[6:].replace("-1.5", "0.5"), "at 0.5, out"),
    ):
        file.write_text(TASK.format(robot="panda") + f"home: {wrong}\n")
        with pytest.raises(RobotError, match=complaint):
            task_robot(load_task(file))


def test_a_batch_s_workers_are_told_which_robot_does_it() -> None:
    from tamp.batch.work import solve_file

    result = solve_file("one_object", "scenarios/one_object.yaml", 0, robot="pander")
    assert result["status"] == "invalid" and "unknown robot 'pander'" in result["message"]


def test_a_package_that_is_installed_meanwhile_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    assert "lately" not in robot_names()
    (tmp_path / "latecomers").mkdir()
    (tmp_path / "latecomers" / "__init__.py").write_text("")
    info = tmp_path / "latecomers-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: latecomers\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[tamp.robots]\nlately = latecomers\n")
    os.utime(tmp_path, ns=(1, 1))  # whatever the clock of the file system
    assert "lately" in robot_names()
