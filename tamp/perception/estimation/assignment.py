"""Who belongs to what, so that the costs are least in sum (Kuhn, 1955)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scipy.optimize import linear_sum_assignment

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


def assigned(costs: NDArray[np.float64]) -> tuple[int, ...]:
    """A column for each row of costs (n, n), so that their sum is least."""
    return tuple(int(column) for column in linear_sum_assignment(costs)[1])
