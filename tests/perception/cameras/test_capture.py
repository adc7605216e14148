"""Frames of a set-up: masks, the robot's part, errors of calibration, and the same for the same seed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tamp.perception.cameras.camera import CalibrationNoise, Camera, Intrinsics
from tamp.perception.cameras.capture import Shot, View, shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.rendering.surface import plain
from tamp.task import Box, Pose, load_robot

pytest.importorskip("embreex", reason="the extra perception is not installed")

PANDA = load_robot("panda")
TOP = Camera(
    "top",
    Intrinsics.from_field_of_view(160, 120, math.radians(60)),
    "world",
    Pose((0.0, 0.0, 0.8), (1.0, 0.0, 0.0, 0.0)),
)
LOOKS = {"a": plain(Box((0.1, 0.1, 0.1))), "b": plain(Box((0.05, 0.05, 0.05)))}
POSES = {"a": Pose((-0.1, 0.25, 0.05)), "b": Pose((-0.1, -0.25, 0.025))}


def _shots(camera: Camera = TOP, *, seed: int = 0, masks: bool = True, poses: dict[str, Pose] = POSES) -> list[Shot]:
    return list(shoot(LOOKS, poses, [View(camera, PANDA.home)] * 2, PANDA, seed=seed, masks=masks))


def test_masks_number_the_objects() -> None:
    frame = _shots()[0].frame
    assert frame.instances is not None
    assert set(np.unique(frame.instances)) == {-1, 0, 1}
    assert _shots(masks=False)[0].frame.instances is None
    absent = _shots(poses={"b": POSES["b"]})[0]
    assert set(np.unique(absent.visible)) == {-1, 1}


def test_the_robot_is_marked_with_a_margin() -> None:
    shot = _shots()[0]
    hand = shot.depth < 0.6  # nothing else is over 0.2 m high
    assert hand.any()
    assert shot.frame.robot[hand & (shot.depth > 0)].all()
    assert not shot.frame.robot[shot.visible == 1].all()


def test_a_perfect_camera_measures_the_truth_where_it_is() -> None:
    shot = _shots()[0]
    assert np.array_equal(shot.frame.depth, shot.depth)
    assert np.array_equal(shot.frame.T_world_camera, shot.T_world_camera)


def test_the_mounts_error_is_common_to_all_views() -> None:
    one = replace(TOP, calibration=CalibrationNoise(view_m=0.0, view_rad=0.0))
    first, second = (shot.frame.T_world_camera for shot in _shots(one))
    assert np.array_equal(first, second)
    assert not np.allclose(first, TOP.T_parent_camera.matrix, atol=1e-5)
    first, second = (shot.frame.T_world_camera for shot in _shots(replace(TOP, calibration=CalibrationNoise())))
    assert not np.allclose(first, second, atol=1e-5)


def test_a_seed_decides_everything() -> None:
    kinect = load_setup()[0]
    small = replace(kinect, intrinsics=kinect.intrinsics.scaled(0.25))
    for a, b in zip(_shots(small, seed=1), _shots(small, seed=1), strict=True):
        assert np.array_equal(a.frame.depth, b.frame.depth)
        assert np.array_equal(a.frame.T_world_camera, b.frame.T_world_camera)
    assert not np.array_equal(_shots(small, seed=1)[0].frame.depth, _shots(small, seed=2)[0].frame.depth)


def test_ocrtocs_set_up_takes_seven_pictures() -> None:
    taken = views(load_setup(), PANDA)
    assert [view.camera.name for view in taken] == ["kinect", *["realsense"] * 6]
    assert taken[0].q == PANDA.home
