"""One cloud from many frames: level, in register, and without what flies."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tamp.perception.cameras.camera import CalibrationNoise, Frame
from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimation.estimator import estimate_poses, see
from tamp.perception.estimation.fusion import fuse, level
from tamp.perception.estimation.registration import register
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Pose, Table, load_robot

pytest.importorskip("embreex", reason="the extra perception is not installed")

PANDA = load_robot("panda")
SIZE = np.array([0.12, 0.08, 0.1])
POSE = Pose.from_rpy((-0.05, 0.05, 0.05), (0, 0, 0.5))
LOOKS = {"block": plain(Box((0.12, 0.08, 0.1)))}


@cache
def _frames(calibration: CalibrationNoise | None) -> tuple[Frame, ...]:
    cameras = [
        replace(c, intrinsics=c.intrinsics.scaled(0.5), calibration=calibration, noise=None) for c in load_setup()
    ]
    return tuple(s.frame for s in shoot(LOOKS, {"block": POSE}, views(cameras, PANDA), PANDA, masks=True))


def _off(points: np.ndarray) -> np.ndarray:
    """Distances of points from the block's surface."""
    local = np.abs((points - POSE.xyz) @ POSE.matrix[:3, :3]) - SIZE / 2
    outside = np.linalg.norm(np.maximum(local, 0), axis=1)
    return np.where((local < 0).all(axis=1), -local.max(axis=1), outside)


def test_points_lie_on_what_was_seen() -> None:
    frames = _frames(None)
    cloud = fuse([level(frame, Table()) for frame in frames], Table())
    assert len(cloud.points) > 1000
    assert cloud.instances is not None
    assert np.percentile(_off(cloud.points[cloud.instances == 0]), 95) < 0.003
    assert (cloud.instances == 0).mean() > 0.95, "nothing but the block stands on the table"


def test_a_tilted_frame_is_levelled() -> None:
    frames = _frames(None)
    tilt = Pose.from_rpy((0.0, 0.0, 0.006), (0.01, -0.008, 0.0)).matrix
    for frame in frames[:3]:
        levelled = level(replace(frame, T_world_camera=tilt @ frame.T_world_camera), Table())
        off = levelled.T_world_camera @ np.linalg.inv(frame.T_world_camera)
        assert np.abs(off[2] - [0, 0, 1, 0]).max() < 2e-3


def test_views_are_moved_on_to_each_other() -> None:
    frames = [level(frame, Table()) for frame in _frames(CalibrationNoise(0.003, 0.004, 0.002, 0.002))]
    mended = register(frames, Table())

    def spread(some: list) -> float:
        points = np.concatenate([fuse([frame], Table()).points for frame in some])
        return float(np.percentile(_off(points) - np.median(_off(points)), 90))

    assert spread(mended) < 0.8 * spread(frames)


def test_space_before_what_was_seen_is_free_and_inside_is_not() -> None:
    volume = see(_frames(None), Table())
    assert volume is not None
    nearest, free = volume.look_up(np.array([POSE.xyz, (-0.05, 0.05, 0.125), (-0.05, 0.05, -0.02)]))
    assert free.tolist() == [False, True, True]
    on_top = volume.look_up(np.array([(-0.05, 0.05, 0.1)]))[0]
    assert on_top[0] >= 0
    assert nearest[0] == -1


def _first_viewpoint(pose: Pose, looks: Surface) -> tuple[Frame, ...]:
    """What the arm's camera sees of one thing from its first viewpoint alone."""
    arm = next(camera for camera in load_setup() if camera.viewpoints)
    arm = replace(arm, viewpoints=arm.viewpoints[:1], calibration=None, noise=None)
    shots = shoot({"it": looks}, {"it": pose}, views([arm], PANDA), PANDA)
    return tuple(shot.frame for shot in shots if shot.frame.camera == arm.name)


LONG = plain(Box((0.1, 0.4, 0.1)))


def _out_of_the_picture() -> tuple[Pose, tuple[Frame, ...]]:
    """A bar of which the picture shows one half; the other reaches out of it."""
    for y in np.arange(0.0, 0.6, 0.05):
        pose = Pose((-0.05, float(y), 0.05))
        frames = _first_viewpoint(pose, LONG)
        scene = see(frames, Table())
        if scene is not None and len(scene.cloud.points) > 300 and np.ptp(scene.cloud.points[:, 1]) < 0.25:
            return pose, frames
    raise AssertionError("no such place")


def test_what_reaches_out_of_the_picture_is_not_seen_through() -> None:
    pose, frames = _out_of_the_picture()
    volume = see(frames, Table())
    assert volume is not None
    along = np.linspace(-0.2, 0.2, 9)[:, None] * [0.0, 1.0, 0.0] + pose.xyz
    assert not volume.look_up(along)[1].any()
    lower, upper = volume.cloud.points.min(axis=0), volume.cloud.points.max(axis=0)
    assert (along < lower - 0.03).any() or (along > upper + 0.03).any(), "some of it lies far beyond what was measured"
    beyond = np.array([(0.0, 0.0, -0.1), (3.0, 0.0, 0.1), (0.0, 0.0, 0.9)])
    assert volume.look_up(beyond)[1].all(), "under the table, beside it and high above it nothing is"


def test_half_of_a_thing_in_one_picture_is_found() -> None:
    pose, frames = _out_of_the_picture()
    found = estimate_poses(frames, {"it": LONG})["it"].pose
    assert found is not None
    assert abs(np.cross(found.matrix[:3, 1], [0.0, 1.0, 0.0])).max() < 0.1
    assert np.abs(np.subtract(found.xyz, pose.xyz)[[0, 2]]).max() < 0.01
