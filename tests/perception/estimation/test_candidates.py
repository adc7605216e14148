"""Poses in one place: of what is round, colours tell the orientation."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimation.candidates import judged, turned
from tamp.perception.estimation.estimator import see
from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.estimation.volume import Volume
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Pose, Table, load_robot

pytest.importorskip("embreex", reason="the extra perception is not installed")

PANDA = load_robot("panda")
RADIUS = 0.035


@cache
def _spotted_ball() -> Surface:
    """A ball with three spots of different colours."""
    ball = trimesh.creation.icosphere(subdivisions=5, radius=RADIUS)
    colors = np.full((len(ball.vertices), 3), (120, 60, 60), dtype=np.uint8)
    for axis, color in enumerate(((230, 230, 230), (40, 160, 60), (60, 60, 220))):
        colors[ball.vertices[:, axis] > 0.8 * RADIUS] = color
    return Surface(np.array(ball.vertices), np.array(ball.faces), colors)


@pytest.mark.parametrize("seed", range(2))
def test_a_balls_orientation_is_told_by_its_spots(seed: int) -> None:
    look = _spotted_ball()
    R = Rotation.random(random_state=seed)
    pose = Pose((-0.05, 0.1, RADIUS), tuple(R.as_quat().tolist()))
    shots = shoot({"ball": look}, {"ball": pose}, views(load_setup(), PANDA), PANDA, seed=seed)
    volume = see([shot.frame for shot in shots], Table())
    assert volume is not None
    model, own = object_model(look), np.arange(len(volume.cloud.points))
    found = judged(volume, model, turned(volume, model, np.array(pose.xyz), own, np.random.default_rng(seed)))
    best = max(found, key=lambda candidate: candidate.weights.sum())
    off = Rotation.from_matrix(best.pose[:3, :3]) * R.inv()
    assert off.magnitude() < math.radians(8)
    assert np.linalg.norm(best.pose[:3, 3] - pose.xyz) < 0.005


def test_few_points_of_a_ball_tell_its_orientation_by_how_likely_they_are() -> None:
    """Sixty points around its top, 2 mm aside, as in a box among others: a tenth of what it would show in the open."""
    model, rng = object_model(_spotted_ball()), np.random.default_rng(0)
    R = Rotation.from_euler("xyz", (0.5, -0.6, 2.0))
    points, normals = R.apply(model.points) + np.array((0.0, 0.0, RADIUS)), R.apply(model.normals)
    shown = rng.permutation(np.flatnonzero(normals[:, 2] > 0.6))[:60]
    cloud = Cloud(points[shown], normals[shown], model.colors[shown])
    cells = (60, 60, 40)
    empty = Volume(cloud, np.array((-0.1, -0.1, 0.0)), np.full(cells, -1, np.int32), np.zeros(cells, np.bool_))
    found = turned(empty, model, np.array((0.002, 0.0, RADIUS)), np.arange(60), rng)
    assert min((Rotation.from_matrix(T[:3, :3]) * R.inv()).magnitude() for T in found[:2]) < math.radians(12)


def test_a_little_of_a_large_surface_that_was_seen_through_costs_about_what_it_is() -> None:
    """In turn each of 15 places of a crate's lid is seen through, 8 cells square: a 750th of all its surface."""
    lid = Pose((0.0, 0.0, 0.12)).matrix
    model, nothing = object_model(plain(Box((0.5, 0.4, 0.2)))), np.zeros((1, 3))
    origin, cells, costs = np.array((-0.28, -0.24, 0.0)), (140, 120, 60), []
    for x in range(20, 120, 20):
        for y in range(30, 90, 20):
            free = np.zeros(cells, dtype=np.bool_)
            free[x : x + 8, y : y + 8, 40:] = True
            volume = Volume(Cloud(nothing, nothing, nothing), origin, np.full(cells, -1, np.int32), free)
            costs += [candidate.free_area for candidate in judged(volume, model, lid[None])]
    assert np.sqrt(np.mean(np.square(np.array(costs) - 64))) < 40
