"""Notes on pictures: read beside each other, and beside what is shown."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.cameras.camera import Frame, Intrinsics, looking_at
from tamp.perception.estimate import Estimate
from tamp.perception.notes import Note, written
from tamp.perception.overlay import overlay
from tamp.perception.rendering.surface import plain
from tamp.task import Box, Pose

RED = np.array([255.0, 0.0, 0.0])
SPOTS = [(100.0, 60.0), (103.0, 62.0), (101.0, 64.0), (99.0, 61.0)]


def _ground(image: np.ndarray) -> np.ndarray:
    """Where a white picture is darkened."""
    return (image < 128).all(axis=2)


def test_notes_at_one_spot_stand_beside_each_other_and_beside_objects() -> None:
    white = np.full((200, 300, 3), 255, dtype=np.uint8)
    shown = np.zeros((200, 300), dtype=np.bool_)
    shown[50:75, 80:120] = True
    alone = int(_ground(written(white, [Note("a name\n100% sure", (100.0, 60.0), RED)], shown)).sum())
    all_of_them = _ground(written(white, [Note("a name\n100% sure", spot, RED) for spot in SPOTS], shown))
    assert int(all_of_them.sum()) == pytest.approx(4 * alone, rel=0.02), "none covers another"
    assert not all_of_them[shown].any(), "and none covers an object"


def test_notes_stay_in_pictures_that_have_no_room() -> None:
    white = np.full((30, 40, 3), 255, dtype=np.uint8)
    full = np.ones((30, 40), dtype=np.bool_)
    drawn = written(white, [Note("something of a long name", spot, RED) for spot in ((39.0, 29.0), (0.0, 0.0))], full)
    assert drawn.shape == white.shape
    assert _ground(drawn).any()
    assert (white == 255).all(), "the picture that was given stays as it is"


def test_a_picture_tells_how_far_an_estimate_is_off() -> None:
    pytest.importorskip("embreex", reason="the extra perception is not installed")
    k = Intrinsics.from_field_of_view(320, 240, 0.8)
    T = looking_at(np.array([0.6, 0.0, 0.5]), np.zeros(3))
    blank = np.zeros((240, 320))
    frame = Frame("c", k, T, np.zeros((240, 320, 3), np.uint8), blank.astype(np.float32), blank.astype(bool))
    looks, estimates = {"brick": plain(Box((0.1, 0.1, 0.1)))}, {"brick": Estimate(Pose((0.0, 0.0, 0.05)), 0.9)}
    without, told = (overlay(frame, looks, estimates, errors=errors) for errors in ({}, {"brick": 0.05}))
    assert (without != told).any()
