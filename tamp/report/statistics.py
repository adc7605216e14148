"""Means and differences with intervals that say how much chance there is in them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

LEVEL = 0.95
RESAMPLES = 4000
Z = 1.959964  # of the normal distribution at LEVEL, both sides


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean with a 95 % confidence interval, and how many values it is of."""

    mean: float
    lower: float
    upper: float
    count: int

    @property
    def excludes_zero(self) -> bool:
        """Whether the interval lies on one side of zero."""
        return self.lower > 0.0 or self.upper < 0.0


def share(successes: int, count: int) -> Estimate:
    """A share with Wilson's score interval (Wilson 1927), which stays within 0..1 and is fit for small counts."""
    if count == 0:
        return Estimate(math.nan, 0.0, 1.0, 0)
    p = successes / count
    middle = (p + Z**2 / (2 * count)) / (1 + Z**2 / count)
    half = Z / (1 + Z**2 / count) * math.sqrt(p * (1 - p) / count + Z**2 / (4 * count**2))
    # At shares of 0 and 1 the bounds are these themselves, which rounding may miss.
    return Estimate(p, min(p, max(0.0, middle - half)), max(p, min(1.0, middle + half)), count)


def mean(groups: Mapping[str, Sequence[float]], seed: int = 0) -> Estimate:
    """The mean of all values with a percentile bootstrap interval (Efron 1979) over groups.

    Values of one group, such as the seeds of one task, belong together: whole groups are drawn again, so that many
    seeds of few tasks do not pass for many tasks.

    Args:
        groups: group -> its values.
        seed: of the resampling.
    """
    values = [np.asarray(group, float) for _, group in sorted(groups.items()) if len(group)]
    if not values:
        return Estimate(math.nan, math.nan, math.nan, 0)
    sums = np.array([group.sum() for group in values])
    counts = np.array([len(group) for group in values])
    drawn = np.random.default_rng(seed).integers(len(values), size=(RESAMPLES, len(values)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    lower, upper = np.quantile(means, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Estimate(float(sums.sum() / counts.sum()), float(lower), float(upper), int(counts.sum()))
