"""How alike colours are whatever the light: hue counts, brightness a little."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

HUE, BRIGHTNESS = 0.07, 0.45
"""Differences of chromaticity, and of the logarithm of brightness, that shading and noise explain."""

LEAST = 0.15
"""What the most different colours still count: fused colours of thin things are mixed with what is behind them."""


def difference(a: Array, b: Array) -> Array:
    """How different colours (..., 3) in 0..1 are, in standard deviations, squared."""
    sum_a, sum_b = a.sum(axis=-1) + 0.05, b.sum(axis=-1) + 0.05
    hue = (((a / sum_a[..., None] - b / sum_b[..., None]) / HUE) ** 2).sum(axis=-1)
    brightness = (np.log(sum_a / sum_b) / BRIGHTNESS) ** 2
    # The hue of what is dark is noise.
    total: Array = hue * np.minimum(1.0, np.minimum(sum_a, sum_b) / 0.6) + brightness
    return total


def alike(a: Array, b: Array) -> Array:
    """How alike colours are, `LEAST`..1."""
    likeness: Array = LEAST + (1 - LEAST) * np.exp(-0.5 * difference(a, b))
    return likeness
