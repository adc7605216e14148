"""Noise models: as large as they say, holes and edges where real sensors have them, the same for the same seed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tamp.perception.cameras.camera import CalibrationNoise, Intrinsics, Noise, StereoNoise, TimeOfFlightNoise
from tamp.perception.cameras.noise import measured, miscalibrated

K = Intrinsics.from_field_of_view(320, 240, math.radians(45))
STEREO = StereoNoise(holes=0.0, quantum=0.0)
FLIGHT = TimeOfFlightNoise(offset=0.0)


def _wall(z: float) -> tuple[np.ndarray, np.ndarray]:
    return np.full((240, 320), z, np.float32), np.ones((240, 320), np.float32)


def _step() -> tuple[np.ndarray, np.ndarray]:
    """A box 0.5 m away before a wall at 1 m, in columns 100 to 199."""
    depth, slant = _wall(1.0)
    depth[:, 100:200] = 0.5
    return depth, slant


def _seen(depth: np.ndarray, slant: np.ndarray, noise: Noise | None, seed: int = 0) -> np.ndarray:
    return measured(depth, slant, K, noise, np.random.default_rng(seed))


@pytest.mark.parametrize("z", [0.5, 1.0])
def test_stereo_errs_with_the_square_of_the_distance(z: float) -> None:
    flat = replace(STEREO, fattening=0)
    error = _seen(*_wall(z), flat) - z
    assert error.std() == pytest.approx(z**2 * flat.disparity / (K.fx * flat.baseline), rel=0.15)


def test_stereo_does_not_see_what_only_one_imager_sees() -> None:
    depth = _seen(*_step(), STEREO)
    shift = K.fx * STEREO.baseline * (1 / 0.5 - 1 / 1.0)
    hole = (depth == 0).sum(axis=1).mean()
    assert shift - 4 < hole < shift + 4
    assert (depth[:, 60:90] == 0).any(), "the shadow lies on the left of the near thing"
    assert not (depth[:, 205:] == 0).any()


def test_stereo_fattens_what_is_near() -> None:
    depth = _seen(*_step(), STEREO)
    near = ((depth > 0.4) & (depth < 0.7)).sum(axis=1).mean()
    assert near == pytest.approx(100 + 2 * STEREO.fattening, abs=1)


def test_stereo_fails_on_grazing_surfaces_and_in_blobs() -> None:
    depth, slant = _wall(1.0)
    slant[:, :50] = math.sin(STEREO.grazing) / 2
    assert not _seen(depth, slant, STEREO)[:, :50].any()
    holes = (_seen(*_wall(1.0), replace(STEREO, holes=0.05)) == 0).mean()
    assert 0.03 < holes < 0.07


def test_time_of_flight_errs_as_it_says() -> None:
    error = _seen(*_wall(1.0), FLIGHT) - 1.0
    assert error.std() == pytest.approx(FLIGHT.range_error, rel=0.05)
    shifts = [(_seen(*_wall(1.0), TimeOfFlightNoise(), seed) - 1.0).mean() for seed in range(50)]
    assert np.std(shifts) == pytest.approx(TimeOfFlightNoise().offset, rel=0.35)


def test_time_of_flight_has_flying_pixels_on_edges_only() -> None:
    depth = _seen(*_step(), FLIGHT)
    flying = (depth > 0.55) & (depth < 0.95)
    assert flying.sum() > 100
    assert set(np.flatnonzero(flying.any(axis=0))) <= {99, 100, 199, 200}


def test_a_slanted_plane_is_no_edge() -> None:
    rays = K.rays()
    normal = np.array([0.0, -math.cos(math.radians(75)), -math.sin(math.radians(15))])
    depth = (normal[2] / (rays @ normal)).astype(np.float32)
    normal /= np.linalg.norm(normal)
    slant = np.abs(rays @ normal / np.linalg.norm(rays, axis=2)).astype(np.float32)
    seen = (depth > FLIGHT.near) & (depth < FLIGHT.far)
    kept = _seen(depth, slant, FLIGHT)[seen]
    assert (kept > 0).mean() > 0.99


@pytest.mark.parametrize("noise", [STEREO, FLIGHT])
def test_the_same_seed_gives_the_same_picture(noise: Noise) -> None:
    assert np.array_equal(_seen(*_step(), noise, 3), _seen(*_step(), noise, 3))
    assert not np.array_equal(_seen(*_step(), noise, 3), _seen(*_step(), noise, 4))


def test_out_of_range_is_no_measurement_and_no_noise_is_the_truth() -> None:
    assert not _seen(*_wall(0.1), STEREO).any()
    assert not _seen(*_wall(5.0), FLIGHT).any()
    assert np.array_equal(_seen(*_step(), None), _step()[0])


def test_calibration_is_off_by_as_much_as_it_says() -> None:
    noise = CalibrationNoise(mount_m=0.002, mount_rad=0.004)
    rng = np.random.default_rng(0)
    off = np.array([miscalibrated(np.eye(4), noise, rng, view=False) for _ in range(400)])
    assert off[:, :3, 3].std() == pytest.approx(0.002, rel=0.1)
    turned = np.arccos((np.trace(off[:, :3, :3], axis1=1, axis2=2) - 1) / 2)
    assert math.sqrt((turned**2).mean() / 3) == pytest.approx(0.004, rel=0.1)
    assert np.allclose(off[:, :3, :3] @ off[:, :3, :3].transpose(0, 2, 1), np.eye(3))
