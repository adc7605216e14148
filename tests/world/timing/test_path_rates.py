"""The fastest rates of a path whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.world.timing.blending import rounded
from tamp.world.timing.path_rates import fastest_rates


def test_a_straight_line_is_followed_by_bang_and_bang() -> None:
    curve = rounded(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), tolerance=0.01)
    grid = np.linspace(0.0, 1.0, 101)
    rates = fastest_rates(curve, grid, np.full(3, 10.0), np.full(3, 2.0))
    assert rates == pytest.approx(np.sqrt(4 * np.minimum(grid, 1 - grid)), abs=1e-6)
