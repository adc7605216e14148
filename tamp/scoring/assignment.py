"""Who takes whose goal, where several objects are alike."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def best_assignment(errors: NDArray[np.float64]) -> tuple[int, ...]:
    """Column for each row so that the sum of the errors is least; errors of shape (n, n).

    By the Hungarian method (Kuhn 1955) as scipy has it.
    """
    from scipy.optimize import linear_sum_assignment

    return tuple(int(column) for column in linear_sum_assignment(errors)[1])
