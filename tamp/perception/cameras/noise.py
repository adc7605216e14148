"""Depth as real sensors measure it: active stereo, time of flight, and calibration, all from a generator given.

Active stereo after Nguyen, Izadi and Lovell (3DIMPVT 2012) and Handa et al. (ICRA 2014): errors live in the disparity.
Time of flight after Horaud et al. (Machine Vision and Applications 27, 2016): errors along the ray, mixed pixels.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

from tamp.perception.cameras.camera import CalibrationNoise, Intrinsics, Noise, StereoNoise, TimeOfFlightNoise
from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Depth = NDArray[np.float32]
    Mask = NDArray[np.bool_]


def measured(
    depth: Depth, slant: Depth, intrinsics: Intrinsics, noise: Noise | None, rng: np.random.Generator
) -> Depth:
    """A depth picture as the sensor would measure it.

    Args:
        depth: true depth, shape (height, width) [m]; 0 is nothing.
        slant: cosine between ray and surface normal, shape (height, width).
        intrinsics: of the picture.
        noise: the sensor's; None measures truly.
        rng: source of every error.

    Returns:
        Shape (height, width), float32 [m]; 0 is no measurement.
    """
    if isinstance(noise, StereoNoise):
        return _stereo(depth, slant, intrinsics, noise, rng)
    if isinstance(noise, TimeOfFlightNoise):
        return _time_of_flight(depth, slant, intrinsics, noise, rng)
    return depth


def miscalibrated(
    T_parent_camera: Array, noise: CalibrationNoise | None, rng: np.random.Generator, *, view: bool
) -> Array:
    """A pose, shape (4, 4), as calibration has it: off by the mount's error, or by one view's."""
    if noise is None:
        return T_parent_camera
    shift, turn = (noise.view_m, noise.view_rad) if view else (noise.mount_m, noise.mount_rad)
    vector = turn * rng.normal(size=3)
    angle = float(np.linalg.norm(vector))
    E = np.eye(4)
    E[:3, :3] = rotation(vector / max(angle, 1e-12), angle)
    E[:3, 3] = shift * rng.normal(size=3)
    T: Array = T_parent_camera @ E
    return T


def _stereo(depth: Depth, slant: Depth, k: Intrinsics, noise: StereoNoise, rng: np.random.Generator) -> Depth:
    scale = k.fx * noise.baseline
    disparity = np.where(depth > 0, scale / np.maximum(depth, 1e-3), 0.0).astype(np.float32)
    # A matching window that holds an edge takes the disparity of the nearer side, which has the stronger texture.
    if noise.fattening:
        disparity = ndimage.maximum_filter(disparity, size=2 * noise.fattening + 1)
    hidden = _half_occluded(disparity)
    disparity += noise.disparity * _correlated(depth.shape, noise.correlation, rng)
    if noise.quantum > 0:
        disparity = np.rint(disparity / noise.quantum) * np.float32(noise.quantum)
    blobs = _correlated(depth.shape, 2 * noise.correlation, rng)
    failed = hidden | (slant < np.sin(noise.grazing)) | (blobs > _quantile(noise.holes))
    z = scale / np.maximum(disparity, 1e-3)
    return _kept(z, (disparity > 0) & ~failed, noise.near, noise.far)


def _half_occluded(disparity: Depth) -> Mask:
    """Pixels that the second imager does not see: a nearer surface to their right lands on theirs in its picture."""
    columns = np.arange(disparity.shape[1], dtype=np.float32)
    lands = columns[None, :] - disparity
    # From the right, the leftmost column taken so far: whoever lands to the right of it is behind something.
    front = np.minimum.accumulate(lands[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(lands > front + 1.5)


def _time_of_flight(
    depth: Depth, slant: Depth, k: Intrinsics, noise: TimeOfFlightNoise, rng: np.random.Generator
) -> Depth:
    valid = depth > 0
    far = np.where(valid, depth, np.float32(0))
    near = np.where(valid, depth, np.float32(np.inf))
    low, high = ndimage.minimum_filter(near, size=3), ndimage.maximum_filter(far, size=3)
    # A slanted surface alone falls by its slope over the two pixels between neighbours.
    slope = np.sqrt(1 / np.maximum(slant, 0.05) ** 2 - 1)
    edge = valid & (high - np.where(valid, low, 0) > noise.edge + 3 * depth / k.fx * slope)
    z = depth + noise.range_error * depth**2 * rng.standard_normal(depth.shape, dtype=np.float32)
    z += np.float32(noise.offset * rng.normal())
    mixed = edge & (rng.random(depth.shape, dtype=np.float32) < noise.mixed)
    share = rng.random(depth.shape, dtype=np.float32)
    z = np.where(mixed, np.where(valid, low, 0) * (1 - share) + high * share, z)
    dropped = edge & (rng.random(depth.shape, dtype=np.float32) < noise.dropped)
    return _kept(z, valid & ~dropped & (slant >= np.sin(noise.grazing)), noise.near, noise.far)


def _kept(z: NDArray[np.floating], mask: Mask, near: float, far: float) -> Depth:
    return np.where(mask & (z > near) & (z < far), z, 0.0).astype(np.float32)


def _correlated(shape: tuple[int, ...], width: float, rng: np.random.Generator) -> Depth:
    """Gaussian noise of standard deviation 1, alike over `width` pixels."""
    noise = rng.standard_normal(shape, dtype=np.float32)
    sigma = width / 2
    if sigma < 0.3:
        return noise
    smooth = ndimage.gaussian_filter(noise, sigma, mode="wrap")
    return np.asarray(smooth / max(float(smooth.std()), 1e-12), dtype=np.float32)


def _quantile(share: float) -> float:
    """What a standard normal variable exceeds with probability `share`."""
    from scipy.special import ndtri

    return float("inf") if share <= 0 else float(-ndtri(share))
