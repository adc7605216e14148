"""The nearest oriented point by cells is the nearest of all."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.perception.estimation.models.buckets import Buckets

FACING = 0.01


@pytest.mark.parametrize("reach", [0.002, 0.015, 0.2])
def test_the_nearest_is_that_of_all(reach: float) -> None:
    rng = np.random.default_rng(3)
    points, wanted = rng.uniform(-0.05, 0.05, (400, 3)), rng.uniform(-0.07, 0.07, (200, 3))
    normals, facing = (values / np.linalg.norm(values, axis=1)[:, None] for values in rng.normal(size=(2, 400, 3)))
    places = np.column_stack([wanted, FACING * facing[:200]])
    found = Buckets.of(points, normals, FACING).nearest(places, reach)
    away = np.linalg.norm(places[:, None] - np.column_stack([points, FACING * normals]), axis=2)
    assert found.tolist() == np.where(away.min(axis=1) < reach, away.argmin(axis=1), -1).tolist()


def test_points_in_one_plane() -> None:
    points = np.array([[0.0, 0.0, 0.1], [0.03, 0.0, 0.1]])
    up = np.tile([0.0, 0.0, 1.0], (2, 1))
    found = Buckets.of(points, up, FACING).nearest(np.column_stack([points[::-1] + 0.001, FACING * up]), 0.005)
    assert found.tolist() == [1, 0]
