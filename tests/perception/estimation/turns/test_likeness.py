"""Turns of shapes that are nearly symmetrical are told by their colours, and by what is not symmetrical."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.estimation.turns.likeness import likeliest_near, likeliest_turn, misfit
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Pose, Sphere
from tamp.world.transforms import rotation

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
    found = likeliest_turn(cloud, model, guess, np.arange(len(cloud.points)))
    assert _turn(found, true) < 6.0


def _turn(one: np.ndarray, other: np.ndarray) -> float:
    """By how much two poses are turned to each other [deg]."""
    return float(np.degrees(np.arccos(np.clip((np.trace(one[:3, :3].T @ other[:3, :3]) - 1) / 2, -1, 1))))


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.5, -0.5, 0.7)])
def test_a_guess_is_turned_about_any_axis_as_colours_tell(axis: tuple[float, float, float]) -> None:
    model, true = object_model(_marked()), Pose.from_rpy((0.1, 0.0, 0.05), (0.3, 0.0, 0.4)).matrix
    cloud = _seen(model, true)
    guess = true @ model.about_center(rotation(np.array(axis) / np.linalg.norm(axis), 0.3))
    found, cost = likeliest_near(cloud, model, guess, np.arange(len(cloud.points)))
    assert _turn(guess, true) > 15.0
    assert _turn(found, true) < 4.0
    assert cost == pytest.approx(misfit(cloud, model, found, np.arange(len(cloud.points))))


def test_what_has_one_colour_is_not_turned_on() -> None:
    model, true = object_model(plain(Sphere(0.036))), np.eye(4)
    cloud = _seen(model, true)
    guess = model.about_center(rotation(np.array((1.0, 0.0, 0.0)), 0.3))
    assert likeliest_near(cloud, model, guess, np.arange(len(cloud.points)))[0] is guess


def test_what_is_a_little_narrower_at_one_end_is_not_turned_round() -> None:
    body, end = plain(Box((0.08, 0.06, 0.04))), plain(Box((0.02, 0.057, 0.037)))
    brick = Surface(
        np.concatenate([body.vertices, end.vertices + np.array((0.05, 0.0, 0.0))]),
        np.concatenate([body.faces, end.faces + len(body.vertices)]),
        np.concatenate([body.colors, end.colors]),
    )
    model, true = object_model(brick), Pose.from_rpy((0.1, 0.0, 0.02), (0.0, 0.0, 0.4)).matrix
    cloud = _seen(model, true)
    assert len(model.symmetries) > 1, "it is nearly symmetrical"
    for turn in model.symmetries:
        found = likeliest_turn(cloud, model, true @ turn, np.arange(len(cloud.points)))
        assert np.allclose(found, true, atol=2e-3)
