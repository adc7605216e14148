"""Set-ups from files: OCRTOC's as published, and one sentence for what is wrong."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tamp.errors import ModelError, TaskError
from tamp.perception.cameras.camera import StereoNoise, TimeOfFlightNoise
from tamp.perception.cameras.setup import load_setup
from tamp.perception.rendering.robot import camera_pose
from tamp.task import load_robot

GOOD = """cameras:
  - name: top
    parent: world
    pose: {xyz: [0, 0, 1], quat: [1, 0, 0, 0]}
    size: [64, 48]
    field_of_view: 0.8
"""


def test_ocrtocs_cameras_look_at_the_table() -> None:
    kinect, realsense = load_setup()
    assert isinstance(kinect.noise, TimeOfFlightNoise)
    assert isinstance(realsense.noise, StereoNoise)
    panda = load_robot("panda")
    assert camera_pose(kinect, panda, panda.home)[:3, 3] == pytest.approx([1.155, 0.091, 0.651], abs=1e-3)
    assert len(realsense.viewpoints) == 6
    for q in realsense.viewpoints:
        T = camera_pose(realsense, panda, q)
        down = np.degrees(np.arcsin(-T[2, 2]))
        assert 0.23 < T[2, 3] < 0.31, "the ring is 24 to 30 cm high"
        assert 32 < down < 48, "and looks 33 to 47 degrees down"


def test_a_camera_in_the_world(tmp_path: Path) -> None:
    path = tmp_path / "setup.yaml"
    path.write_text(GOOD, encoding="utf-8")
    (camera,) = load_setup(path)
    assert (camera.noise, camera.calibration, camera.viewpoints) == (None, None, ())
    assert camera_pose(camera, load_robot("panda"), ())[:3, 2] == pytest.approx([0, 0, -1])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("    size: [64, 48]\n", "", r"setup.yaml:2: cameras\[0\]: size is missing"),
        ("size: [64, 48]", "size: [64, -1]", r"setup.yaml:5: cameras\[0\].size: expected \[width, height\]"),
        ("field_of_view: 0.8", "field_of_view: 45", "45 is not an angle between 0.01 and 3 rad"),
        ("field_of_view: 0.8", "lens: 8", "lens: unknown; valid are name, parent"),
        ("field_of_view: 0.8", "field_of_view: 0.8\n    noise: {kind: sonar}", "'sonar' is unknown; valid are stereo"),
        ("field_of_view: 0.8", "field_of_view: 0.8\n    noise: {kind: stereo, holes: -1}", "-1 is not a number of at"),
        ("field_of_view: 0.8", "field_of_view: 0.8\n    noise: {kind: stereo, holes: 2}", "2 is not .* and at most 1$"),
        (
            "field_of_view: 0.8",
            "field_of_view: 0.8\n    noise: {kind: stereo, near: .nan}",
            "nan is not a number of at",
        ),
        (
            "field_of_view: 0.8",
            "field_of_view: 0.8\n    noise: {kind: stereo, fattening: 1.5}",
            "is not a whole number",
        ),
        (
            "field_of_view: 0.8",
            "field_of_view: 0.8\n    noise: {kind: stereo, near: 4}",
            "4 m is not nearer than far, 3",
        ),
        ("field_of_view: 0.8", "field_of_view: 0.8\n    calibration: {mount_m: .inf}", "mount_m: inf is not a number"),
        ("field_of_view: 0.8", "intrinsics: [0, 60, 32, 24]", "fx and fy must be over 0 pixels, not 0 and 60"),
        (
            "field_of_view: 0.8",
            "intrinsics: [60, 60, 32, 2400]",
            "the principal point, 32, 2400, is not in a picture of",
        ),
        ("field_of_view: 0.8", "intrinsics: [60, 60, .nan, 24]", "intrinsics: expected 4 numbers"),
        ("size: [64, 48]", "size: [64, .inf]", "size: expected 2 numbers"),
        ("size: [64, 48]", "size: [64, 1000000]", r"expected \[width, height\] in pixels, 1 to 8192 each"),
        ("quat: [1, 0, 0, 0]", "quat: [0, 0, 0, 0]", "length zero"),
        ("xyz: [0, 0, 1]", "xyz: [0, 1.0e+300, 1]", r"setup.yaml:4: cameras\[0\].pose.xyz: a camera is at most 1000 m"),
        ("field_of_view: 0.8", "field_of_view: 0.8\n    calibration: {mount_m: 1.0e+300}", "mount_m: .* at most 1000$"),
        ("quat: [1, 0, 0, 0]", "quat: [1, 0, 0]", r"pose.quat: expected 4 numbers"),
        ("cameras:", "camera:", "expected cameras:"),
        (
            "name: top",
            "name: ../top",
            r"setup.yaml:2: cameras\[0\].name: '../top' has other signs than letters, digits",
        ),
        (
            "parent: world",
            "parent: world\n    viewpoints: [[0, 0, 0, -1.5, 0, 1.5, 0]]",
            r"setup.yaml:4: cameras\[0\].viewpoints: a camera in the world does not go where the arm does",
        ),
    ],
)
def test_a_wrong_set_up_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    path = tmp_path / "setup.yaml"
    assert old in GOOD
    path.write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.raises(TaskError, match=said):
        load_setup(path)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (
            "parent: panda_hnd",
            r"setup.yaml:3: .*no link 'panda_hnd'; the URDF has .*panda_hand.*; or world$",
        ),
        ("parent: panda_joint1", "no link 'panda_joint1'; the URDF has (?!.*panda_joint1)"),
        ("parent: panda_hand\n    viewpoints: [[0, 0]]", r"setup.yaml:4: .*viewpoints\[0\]: expected 7 numbers"),
        (
            "parent: panda_hand\n    viewpoints: [[0, 0, 0, 0.5, 0, 1.5, 0]]",
            r"setup.yaml:4: .*viewpoints\[0\]: panda_joint4 goes from -3.0718 to -0.0698 rad, not to 0.5$",
        ),
    ],
)
def test_a_camera_that_the_robot_cannot_carry_is_refused(tmp_path: Path, lines: str, said: str) -> None:
    path = tmp_path / "setup.yaml"
    path.write_text(GOOD.replace("parent: world", lines), encoding="utf-8")
    with pytest.raises(TaskError, match=said):
        load_setup(path, load_robot("panda"))


@pytest.mark.parametrize("wrong", [{"holes": 1.1}, {"disparity": math.nan}, {"far": 0.1}])
def test_noise_that_is_none_is_refused_in_python_too(wrong: dict[str, float]) -> None:
    with pytest.raises(ModelError, match=next(iter(wrong)) if "far" not in wrong else "nearer than far"):
        StereoNoise(**wrong)


def test_two_cameras_of_one_name_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "setup.yaml"
    path.write_text(GOOD + GOOD.removeprefix("cameras:\n"), encoding="utf-8")
    with pytest.raises(TaskError, match="a second camera is called 'top'"):
        load_setup(path)
