"""Turns of a plate that differ by tenths of a millimetre are told by whole pictures, whatever the cameras get wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import load_setup
from tamp.perception.estimation.estimator import estimate_poses
from tamp.perception.estimation.fusion import level
from tamp.perception.estimation.models.object_model import object_model
from tamp.perception.estimation.turns.rendered import CLOSELY, _costs, turn_shown
from tamp.perception.evaluation import pose_error
from tamp.perception.rendering.surface import GREY, Surface, plain
from tamp.task import Box, Pose, Table, load_robot

pytest.importorskip("embreex", reason="the extra perception is not installed")

CAMERAS = tuple(replace(c, intrinsics=c.intrinsics.scaled(0.5)) for c in load_setup())
PANDA, SIDE, HIGH, CELLS = load_robot("panda"), 0.09, 0.02, 24


def _plate(bump: float) -> Surface:
    """A square plate with a rim, as a grid of heights that are `bump` higher along one side [m]; grey."""
    axis = np.linspace(-SIDE, SIDE, CELLS)
    x, y = (values.ravel() for values in np.meshgrid(axis, axis, indexing="ij"))
    height = 0.004 + (HIGH - 0.004) * np.clip((np.maximum(np.abs(x), np.abs(y)) - 0.05) / 0.035, 0.0, 1.0)
    height += bump * np.maximum(0.0, np.cos(math.pi * y / (2 * SIDE))) * (x > 0.03)
    low = np.column_stack([x, y, height - 0.003])
    corner = (np.arange(CELLS - 1)[:, None] * CELLS + np.arange(CELLS - 1)).ravel()
    quads = np.column_stack([corner, corner + CELLS, corner + CELLS + 1, corner + 1])
    top = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    faces = np.concatenate([top, top[:, ::-1] + CELLS**2])
    vertices = np.concatenate([np.column_stack([x, y, height]), low])
    return Surface(vertices, faces, np.tile(np.array(GREY, np.uint8), (len(vertices), 1)))


PLATE = _plate(0.0008)
TURNS = [Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw)).matrix for yaw in (0.0, math.pi / 2, math.pi, -math.pi / 2)]


def _shots(true: Pose, seed: int) -> list:
    return list(shoot({"plate": PLATE}, {"plate": true}, views(CAMERAS, PANDA), PANDA, seed=seed))


@pytest.mark.parametrize("seed", range(2))
def test_a_plates_turn_is_told_by_less_than_a_millimetre(seed: int) -> None:
    true = Pose.from_rpy((-0.05, 0.1, 0.0), (0.0, 0.0, 0.4 + seed))
    frames = [level(shot.frame, Table()) for shot in _shots(true, seed)]
    for first in (0, 3):
        poses = np.stack([true.matrix @ TURNS[(first + k) % 4] for k in range(4)])
        assert turn_shown(frames, PLATE, poses) == (4 - first) % 4


def test_the_perceiver_says_that_turn() -> None:
    model, true = object_model(PLATE), Pose.from_rpy((-0.05, 0.1, 0.0), (0.0, 0.0, 2.0))
    assert len(model.symmetries) == 4, "points alone could not tell"
    found = estimate_poses([shot.frame for shot in _shots(true, 0)], {"plate": PLATE})["plate"].pose
    assert found is not None
    assert pose_error(model, found, true)[1] < 0.005


def test_what_is_small_is_looked_at_closely() -> None:
    small = Surface(0.4 * _plate(0.003).vertices, PLATE.faces, PLATE.colors)
    true = Pose.from_rpy((-0.05, 0.1, 0.0), (0.0, 0.0, 0.4))
    shots = shoot({"small": small}, {"small": true}, views(CAMERAS, PANDA), PANDA)
    poses = np.stack([true.matrix @ turn for turn in TURNS[::-1]])
    assert turn_shown([level(shot.frame, Table()) for shot in shots], small, poses) == 3


def _step(depth: float) -> Surface:
    """A block whose foot stands back under its top on one side [m]."""
    foot, top = plain(Box((0.16 - depth, 0.16, 0.05))), plain(Box((0.16, 0.16, 0.006)))
    vertices = np.concatenate(
        [np.add(foot.vertices, (-depth / 2, 0.0, 0.025)), np.add(top.vertices, (0.0, 0.0, 0.053))]
    )
    faces = np.concatenate([foot.faces, top.faces + len(foot.vertices)])
    return Surface(vertices, faces, np.tile(np.array(GREY, np.uint8), (len(vertices), 1)))


@pytest.mark.parametrize("depth", [0.006, 0.012, 0.018])
@pytest.mark.parametrize("first", [0, 1])
def test_where_turns_differ_by_much_tells_most(depth: float, first: int) -> None:
    step, true = _step(depth), Pose.from_rpy((-0.05, 0.1, 0.0), (0.0, 0.0, 0.3))
    shots = shoot({"step": step}, {"step": true}, views(CAMERAS, PANDA), PANDA, seed=0)
    poses = np.stack([true.matrix @ TURNS[2 * k] for k in (first, 1 - first)])
    found = _costs([level(shot.frame, Table()) for shot in shots], [(step, poses)], CLOSELY)
    assert found is not None
    (costs,) = found
    assert int(costs.argmin()) == first
    assert costs.max() > costs.min() + 200, "not by noise"


def test_what_no_frame_shows_tells_nothing() -> None:
    true = Pose((-0.05, 0.1, 0.0))
    frames = [level(shot.frame, Table()) for shot in _shots(true, 0)]
    assert turn_shown(frames, PLATE, np.stack([Pose((5.0, 0.0, 0.0)).matrix @ turn for turn in TURNS])) is None
    assert turn_shown([], PLATE, np.stack(TURNS)) is None
