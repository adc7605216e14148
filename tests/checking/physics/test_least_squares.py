from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.physics.least_squares import nnls


@given(rows=st.integers(1, 30), columns=st.integers(1, 120), seed=st.integers(0, 10_000), depend=st.booleans())
@settings(max_examples=60, deadline=None)
def test_non_negative_least_squares_are_where_nothing_more_is_gained(rows, columns, seed, depend):
    """Karush, Kuhn and Tucker's conditions, also where columns are each other's sums."""
    rng = np.random.default_rng(seed)
    A, b = rng.normal(size=(rows, columns)), rng.normal(size=rows)
    if depend:
        A[:, columns // 2 :] = A[:, : columns - columns // 2] @ rng.uniform(0.0, 1.0, (columns - columns // 2,) * 2)
    x, far = nnls(A, b)
    left = b - A @ x
    gain = A.T @ left / np.maximum(np.linalg.norm(A, axis=0), 1e-12)
    assert (x >= 0.0).all() and far == pytest.approx(np.linalg.norm(left), abs=1e-9)
    assert gain.max() < 1e-7 and np.abs(gain[x > 0.0]).max(initial=0.0) < 1e-6
