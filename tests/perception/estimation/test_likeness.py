"""Turns of round shapes are told by their colours."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.likeness import turned_by_color
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Pose, Sphere

pytest.importorskip("embreex", reason="the extra perception is not installed")


def _marked() -> Surface:
    """A ball, orange, with two marks."""
    surface = plain(Sphere(0.036))
    ways = surface.vertices / np.linalg.norm(surface.vertices, axis=1)[:, None]
    colors = np.tile(np.array((230, 140, 40), np.uint8), (len(ways), 1))
    colors[ways @ np.array((1.0, 0.0, 0.0)) > 0.9] = (60, 80, 30)
    colors[ways @ np.array((0.6, 0.8, 0.0)) > 0.9] = (150, 60, 30)
    return Surface(surface.vertices, surface.faces, colors)


def _seen(model: ObjectModel, pose: np.ndarray) -> Cloud:
    """Most of a surface."""
    points, normals = model.points @ pose[:3, :3].T + pose[:3, 3], model.normals @ pose[:3, :3].T
    most = normals @ np.array((0.8, 0.0, 0.6)) > -0.2
    return Cloud(points[most], normals[most], model.colors[most])


@pytest.mark.parametrize(("yaw", "tilt"), [(0.4, 0.3), (1.3, 0.5), (2.6, 0.9)])
def test_a_balls_turn_is_found_between_those_that_stand_for_all(yaw: float, tilt: float) -> None:
    model = object_model(_marked())
    true = Pose.from_rpy((0.1, 0.0, 0.05), (tilt, 0.0, yaw)).matrix
    cloud, guess = _seen(model, true), Pose((0.1, 0.0, 0.05)).matrix
    found = turned_by_color(cloud, model, guess, np.arange(len(cloud.points)))
    turn = found[:3, :3].T @ true[:3, :3]
    assert np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))) < 6.0
