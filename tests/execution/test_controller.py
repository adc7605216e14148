from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.execution.controller import positions_at, set_points
from tamp.execution.simulator import STEP
from tamp.task import Trajectory


def cubic(coefficients, times):
    """A trajectory sampled from a cubic polynomial per joint; coefficients of shape (4, joints)."""
    c, t = np.asarray(coefficients, dtype=float), np.asarray(times, dtype=float)[:, None]
    return Trajectory(
        np.asarray(times, dtype=float),
        c[0] + c[1] * t + c[2] * t**2 + c[3] * t**3,
        c[1] + 2 * c[2] * t + 3 * c[3] * t**2,
    )


@given(
    c=st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), min_size=4, max_size=4),
    cuts=st.lists(st.floats(0.05, 0.5), min_size=1, max_size=6),
    at=st.floats(0, 1),
)
def test_a_cubic_is_its_own_hermite_curve(c, cuts, at):
    times = np.r_[0.0, np.cumsum(cuts)]
    trajectory = cubic(c, times)
    t = at * times[-1]
    exact = np.array([1, t, t**2, t**3]) @ np.asarray(c)
    assert positions_at(trajectory, np.array([t]))[0] == pytest.approx(exact, abs=1e-9)


def test_the_arm_rests_before_and_after():
    trajectory = cubic([[0.0], [0.0], [3.0], [-2.0]], [0.0, 0.5, 1.0])
    assert positions_at(trajectory, np.array([-1.0, 2.0])).ravel() == pytest.approx([0.0, 1.0])


def test_set_points_lead_from_start_to_end():
    trajectory = cubic([[0.1], [0.0], [3.0], [-2.0]], np.linspace(0, 1, 7))
    q, v = set_points(trajectory, STEP)
    assert len(q) == len(v) == 240
    assert q[0] == pytest.approx([0.1])
    assert q[0] + v.sum(axis=0) * STEP == pytest.approx([1.1])


def test_a_trajectory_of_one_sample_stands_still():
    trajectory = Trajectory(np.zeros(1), np.array([[0.3, 0.4]]), np.zeros((1, 2)))
    q, v = set_points(trajectory, STEP)
    assert q.tolist() == [[0.3, 0.4]]
    assert not v.any()
