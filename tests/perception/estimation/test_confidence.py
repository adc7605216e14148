"""What an estimate is trusted by, besides what it explains: that what it explains ends where the object does."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimation.candidates import Candidate
from tamp.perception.estimation.confidence import confidence, lead
from tamp.perception.estimation.estimator import estimate_poses
from tamp.perception.estimation.fusion import FEWEST, VOXEL, Cloud, Left
from tamp.perception.estimation.verification import CLOSER, SHOWN, Verified
from tamp.perception.rendering.surface import plain
from tamp.task import Box, Pose, load_robot

EXPLAINED = (0.02, 0.06)
"""Along x, what an estimate explains of a strip [m]."""


def _strip(length: float) -> Cloud:
    """A level strip from x = 0, 4 cm wide, by one point a cell."""
    x, y = np.meshgrid(np.arange(0, length, VOXEL), np.arange(0, 0.04, VOXEL), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.02)])
    return Cloud(points, np.tile((0.0, 0.0, 1.0), (len(points), 1)), np.zeros((len(points), 3)))


def _goes_on(cloud: Cloud, explained: Sequence[float]) -> float:
    own = (cloud.points[:, 0] > explained[0]) & (cloud.points[:, 0] < explained[1])
    return Left.of(cloud, own.astype(float)).goes_on(cloud.points[own])


def test_what_is_cut_out_of_a_larger_surface_goes_on() -> None:
    assert _goes_on(_strip(0.3), EXPLAINED) > 0.4


@pytest.mark.parametrize("length", [0.061, 0.069])
def test_a_fringe_along_an_edge_is_no_surface_that_goes_on(length: float) -> None:
    assert _goes_on(_strip(length), (0.0, 0.06)) == 0


def test_a_few_points_beyond_are_no_surface() -> None:
    cloud = _strip(0.06)
    speck = cloud.points[: FEWEST - 1] + np.array((0.07, 0.0, 0.0))
    points = np.concatenate([cloud.points, speck])
    left = Left.of(Cloud(points, np.zeros_like(points), np.zeros_like(points)), (points[:, 0] < 0.0601).astype(float))
    assert left.goes_on(points) == 0


def test_nothing_left_and_nothing_explained() -> None:
    cloud = _strip(0.1)
    assert Left.of(cloud, np.ones(len(cloud.points))).goes_on(cloud.points) == 0
    assert Left.of(cloud, np.zeros(len(cloud.points))).goes_on(np.empty((0, 3))) == 0


def test_a_part_of_what_is_not_listed_is_no_object() -> None:
    """One camera sees a board that it is told nothing of; a lath of its thickness fits its corners alone."""
    pytest.importorskip("embreex", reason="the extra perception is not installed")
    robot = load_robot("panda")
    fixed = tuple(camera for camera in load_setup() if not camera.viewpoints)
    looks = {"board": plain(Box((0.16, 0.1, 0.02))), "lath": plain(Box((0.1, 0.03, 0.02)))}
    pose = Pose.from_rpy((-0.05, 0.1, 0.01), (0.0, 0.0, 0.5))
    for there, least, most in (("lath", 0.5, 1.0), ("board", 0.0, 0.3)):
        shots = shoot({there: looks[there]}, {there: pose}, views(fixed, robot), robot)
        found = estimate_poses([shot.frame for shot in shots], {"lath": looks["lath"]})
        assert least <= found["lath"].confidence <= most


def test_a_scrap_of_a_large_surface_is_no_sight_of_an_object() -> None:
    nothing = np.empty(0, np.int64), np.full(400, 1.0)
    of = [confidence(Candidate(np.eye(4), *nothing, hits, 0.0, 0.0), 400.0, 0.0, 10.0, 0.0) for hits in (0.04, 0.2)]
    assert of[0] < 0.5 < 0.95 < of[1]


def test_what_shares_more_than_half_of_what_it_explains_with_others_is_uncertain() -> None:
    """As a bowl in a bowl, both of which fit: the one whose points the other explains as well may be anywhere."""
    best = Candidate(np.eye(4), np.arange(500), np.full(500, 1.0), 0.15, 0.0, 0.0)
    of = [confidence(best, gain, 0.0, 10.0, 0.0) for gain in (200.0, 400.0)]
    assert of[0] < 0.3 < 0.5 < of[1]


@pytest.mark.parametrize(("exchanged", "told", "ahead"), [(np.inf, 0.0, 0.5), (np.inf, 4.0, 4.0), (1.5, 4.0, 1.5)])
def test_a_turn_that_pictures_tell_counts_as_one_that_points_do(exchanged: float, told: float, ahead: float) -> None:
    """Points of a book's back fit it the other way round nearly as well; pictures that tell do not tell who it is."""
    alone: Any = SimpleNamespace(center=lambda *_: None, at=lambda *_: [0], lead_over_absent=lambda _: np.inf)
    turned = Verified(0, np.eye(4), np.arange(9), 0.5 * CLOSER, rival=np.eye(4), exchanged=exchanged * CLOSER)
    assert lead(alone, 0, np.array([100.0]), [], turned, told * SHOWN) == pytest.approx(ahead)


def test_what_another_that_was_found_nowhere_could_be_is_uncertain() -> None:
    """Two boards are listed and one is there: the other one is told from it by its size, or by nothing."""
    pytest.importorskip("embreex", reason="the extra perception is not installed")
    robot = load_robot("panda")
    fixed = tuple(camera for camera in load_setup() if not camera.viewpoints)
    there = plain(Box((0.12, 0.1, 0.03)))
    pose = Pose.from_rpy((-0.05, 0.1, 0.015), (0.0, 0.0, 0.5))
    frames = [shot.frame for shot in shoot({"board": there}, {"board": pose}, views(fixed, robot), robot)]
    for other, least, most in (((0.12, 0.1, 0.0302), 0.0, 0.3), ((0.2, 0.16, 0.06), 0.5, 1.0)):
        looks = {"board": there, "other": plain(Box(other))}
        found = estimate_poses(frames, looks)
        assert sum(estimate.pose is not None for estimate in found.values()) == 1
        assert least <= max(estimate.confidence for estimate in found.values()) <= most
