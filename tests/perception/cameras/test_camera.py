"""Pinhole geometry: what is projected comes back, and a field of view is as wide as it says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.perception.cameras.camera import BASE_TO_OPTICAL, Intrinsics

K = Intrinsics.from_field_of_view(64, 48, math.radians(45))


@given(st.integers(0, 63), st.integers(0, 47), st.floats(0.2, 3.0))
def test_a_pixels_point_projects_to_its_centre(u: int, v: int, z: float) -> None:
    depth = np.full((48, 64), z, dtype=np.float32)
    point = K.points(depth)[v, u].astype(np.float64)
    pixels, depths = K.project(point[None])
    assert pixels[0] == pytest.approx((u + 0.5, v + 0.5), abs=1e-3)
    assert depths[0] == pytest.approx(z, rel=1e-6)


def test_the_field_of_view_is_the_vertical_one() -> None:
    assert 2 * math.atan(24 / K.fy) == pytest.approx(math.radians(45))
    assert K.matrix.tolist() == [[K.fx, 0, 32], [0, K.fy, 24], [0, 0, 1]]


def test_half_the_size_sees_the_same() -> None:
    half = K.scaled(0.5)
    point = np.array([[0.1, -0.05, 1.0]])
    assert (half.width, half.height) == (32, 24)
    assert half.project(point)[0] == pytest.approx(K.project(point)[0] / 2)


def test_a_picture_has_a_pixel_however_small_it_is_made() -> None:
    small = Intrinsics(1, 1, 50.0, 50.0, 0.5, 0.5).scaled(0.5)
    assert (small.width, small.height) == (1, 1)


def test_optical_axes_in_the_body_frame() -> None:
    right, down, forward = BASE_TO_OPTICAL.matrix[:3, :3].T
    assert right == pytest.approx([0, -1, 0])
    assert down == pytest.approx([0, 0, -1])
    assert forward == pytest.approx([1, 0, 0])
