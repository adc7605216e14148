"""The fastest rates are those of linear programs, one for each point of the grid, and keep every limit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from tamp.world.timing.blending import RoundedPath, rounded
from tamp.world.timing.path_rates import fastest_rates

DOF = 3
VELOCITY, ACCELERATION = np.array([2.0, 1.0, 3.0]), np.array([5.0, 4.0, 20.0])


def random_curve(seed: int, edges: int, scale: float) -> tuple[RoundedPath, np.ndarray]:
    rng = np.random.default_rng(seed)
    curve = rounded(np.cumsum(scale * rng.normal(size=(edges + 1, DOF)), axis=0), tolerance=0.01)
    between = rng.uniform(0.0, curve.arc[-1], size=12)
    return curve, np.unique(np.concatenate([curve.breaks, between]))


curves = st.builds(random_curve, st.integers(0, 2**32 - 1), st.integers(1, 4), st.sampled_from([0.01, 1.0]))


def limits(curve: RoundedPath, grid: np.ndarray, i: int) -> np.ndarray:
    """Rows p, q with |p u + q x| <= 1: accelerations at both ends of interval i as shares of the largest."""
    first, second = curve(grid, 1) / ACCELERATION, curve(grid, 2) / ACCELERATION
    ahead = first[i + 1] + 2 * (grid[i + 1] - grid[i]) * second[i + 1]
    return np.vstack([np.stack([first[i], second[i]], axis=1), np.stack([ahead, second[i + 1]], axis=1)])


def controllable(curve: RoundedPath, grid: np.ndarray) -> np.ndarray:
    """At each point the largest x from which the end can be reached at rest, by a solver of linear programs."""
    most = (VELOCITY / np.maximum(np.abs(curve(grid, 1)), 1e-12)).min(axis=1) ** 2
    reach = np.zeros(len(grid))
    for i in range(len(grid) - 2, -1, -1):
        ahead = np.array([[2 * (grid[i + 1] - grid[i]), 1.0]])
        A = np.vstack([limits(curve, grid, i), -limits(curve, grid, i), ahead, -ahead])
        b = np.array([1.0] * 4 * DOF + [reach[i + 1], 0.0])
        found = linprog([0.0, -1.0], A_ub=A, b_ub=b, bounds=[(None, None), (0.0, most[i])])
        reach[i] = found.x[1]
    return reach


@settings(max_examples=25, deadline=None)
@given(curves)
def test_limits_are_kept_and_nothing_faster_could_stop_in_time(case: tuple[RoundedPath, np.ndarray]) -> None:
    curve, grid = case
    rates = fastest_rates(curve, grid, VELOCITY, ACCELERATION)
    x = rates**2
    u = np.diff(x) / (2 * np.diff(grid))
    assert rates[0] == rates[-1] == 0.0 and np.isfinite(rates).all() and (rates[1:] + rates[:-1] > 0).all()
    assert (np.abs(curve(grid, 1)) * rates[:, None] <= VELOCITY * (1 + 1e-9)).all()
    highest = controllable(curve, grid)
    assert (x <= highest * (1 + 1e-6) + 1e-6).all()
    for i in range(len(u)):
        shares = np.abs(limits(curve, grid, i) @ [u[i], x[i]])
        assert shares.max() <= 1 + 1e-6
        # As fast as it may be: some limit is reached, or the next point is one that must not be passed any faster.
        assert shares.max() > 1 - 1e-6 or x[i + 1] == pytest.approx(highest[i + 1], rel=1e-5, abs=1e-6)


def test_a_straight_line_is_followed_by_bang_and_bang() -> None:
    curve = rounded(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), tolerance=0.01)
    grid = np.linspace(0.0, 1.0, 101)
    rates = fastest_rates(curve, grid, np.full(3, 10.0), np.full(3, 2.0))
    assert rates == pytest.approx(np.sqrt(4 * np.minimum(grid, 1 - grid)), abs=1e-9)
