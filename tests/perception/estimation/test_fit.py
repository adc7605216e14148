"""Poses agree with what was measured where the object is, and move there from near by."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.estimation.fit import agreement, glance, polished, refine
from tamp.perception.estimation.fusion import VOXEL, Cloud
from tamp.perception.estimation.matching import distinct
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.estimation.volume import Volume
from tamp.perception.rendering.surface import plain
from tamp.task import Box, Cylinder, Pose

pytest.importorskip("embreex", reason="the extra perception is not installed")

TRUE = Pose.from_rpy((0.1, -0.05, 0.03), (0.0, 0.0, 0.4)).matrix


@pytest.fixture(scope="module")
def brick() -> ObjectModel:
    return object_model(plain(Box((0.12, 0.08, 0.06)), (200, 60, 60)))


@pytest.fixture(scope="module")
def volume(brick: ObjectModel) -> Volume:
    """All of the brick but its underside, and all space around it seen through."""
    points, normals = brick.points @ TRUE[:3, :3].T + TRUE[:3, 3], brick.normals @ TRUE[:3, :3].T
    seen = normals[:, 2] > -0.5
    cloud = Cloud(points[seen], normals[seen], brick.colors[seen])
    origin = np.array([-0.05, -0.2, 0.0])
    shape = np.array([75, 75, 25])
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1)
    centers = origin + (cells + 0.5) * VOXEL
    away = np.linalg.norm(centers[:, :, :, None] - cloud.points[::4], axis=-1)
    nearest = np.where(away.min(axis=-1) < 0.016, 4 * away.argmin(axis=-1), -1).astype(np.int32)
    local = np.abs((centers - TRUE[:3, 3]) @ TRUE[:3, :3])
    return Volume(cloud, origin, nearest, (nearest < 0) & (local > [0.06, 0.04, 0.03]).any(axis=-1))


def _off(roll: float, x: float, z: float = 0.0) -> np.ndarray:
    return TRUE @ Pose.from_rpy((x, 0.0, z), (roll, 0.0, 0.1)).matrix


def test_the_true_pose_agrees_best(volume: Volume, brick: ObjectModel) -> None:
    poses = np.stack([TRUE, _off(0.2, 0.01), _off(0.0, 0.05), _off(0.0, 0.0, 0.2)])
    found = agreement(volume, brick, poses)
    assert found.score.argmax() == 0
    assert found.hits[0] > 0.6
    assert found.violations[0] < 0.02 < found.violations[2] < found.violations[3] == 1.0
    assert glance(volume, brick, poses, 100).argmax() == 0


def test_under_the_table_nothing_can_be(volume: Volume, brick: ObjectModel) -> None:
    sunk = agreement(volume, brick, _off(0.0, 0.0, -0.04)[None])
    assert sunk.violations[0] > 0.3


def test_other_colours_agree_less(volume: Volume, brick: ObjectModel) -> None:
    blue = object_model(plain(Box((0.12, 0.08, 0.06)), (60, 60, 200)))
    assert agreement(volume, blue, TRUE[None]).hits[0] < 0.5 * agreement(volume, brick, TRUE[None]).hits[0]


def test_poses_move_on_to_what_was_measured(volume: Volume, brick: ObjectModel) -> None:
    started = np.stack([_off(0.05, 0.006), _off(-0.05, -0.006)])
    moved = refine(volume, brick, started, rounds=20)
    assert np.linalg.norm(started[:, :3, 3] - TRUE[:3, 3], axis=1).min() > 0.005
    assert np.linalg.norm(moved[:, :3, 3] - TRUE[:3, 3], axis=1).max() < 0.001
    turned = np.einsum("nij,ij->n", moved[:, :3, :3], TRUE[:3, :3])
    assert turned.min() > 1 + 2 * np.cos(0.01)


@pytest.mark.parametrize("seed", range(3))
def test_the_last_fit_moves_but_does_not_roll_a_thin_round_thing(seed: int) -> None:
    """A marker: points say nothing of the roll about its axis, and their noise must not be taken for it."""
    marker = object_model(plain(Cylinder(0.009, 0.13)))
    lying = Pose.from_rpy((0.1, -0.05, 0.009), (np.pi / 2, 0.0, 0.4)).matrix
    rng = np.random.default_rng(seed)
    points, normals = marker.points @ lying[:3, :3].T + lying[:3, 3], marker.normals @ lying[:3, :3].T
    points += 0.0008 * rng.normal(size=(len(points), 1)) * normals
    seen = np.flatnonzero(normals[:, 2] > -0.2)
    normals += 0.15 * rng.normal(size=normals.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    start = lying @ Pose.from_rpy((0.002, 0.0, 0.004), (0.03, 0.02, 0.0)).matrix
    found = polished(Cloud(points, normals, marker.colors), marker, start, seen)
    assert np.linalg.norm(found[:3, 3] - lying[:3, 3]) < 0.0005 < np.linalg.norm(start[:3, 3] - lying[:3, 3])
    assert found[:3, 2] @ lying[:3, 2] > np.cos(0.01) > start[:3, 2] @ lying[:3, 2]
    turn = start[:3, :3].T @ found[:3, :3]
    assert abs(np.degrees(np.arctan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))) < 3


def test_poses_near_an_earlier_one_are_left_out() -> None:
    poses = np.stack([TRUE, _off(0.05, 0.001), _off(0.05, 0.02), _off(0.5, 0.0), TRUE])
    centers = np.ascontiguousarray(poses[:, :3, 3])
    trace = 1 + 2 * np.cos(0.2)
    assert distinct(poses, centers, 0.005, trace, 5).tolist() == [0, 2, 3]
    assert distinct(poses, centers, 0.005, trace, 2).tolist() == [0, 2]
