from __future__ import annotations

import math
from typing import Any

import numpy as np

import tamp.compiled
from tamp.compiled import compiled


def _reciprocals(values: np.ndarray) -> np.ndarray:
    found = np.empty_like(values)
    for i in range(len(values)):
        found[i] = 1.0 / values[i]
    return found


def test_a_compiled_loop_divides_by_zero_as_numpy_does() -> None:
    assert compiled(_reciprocals)(np.array([2.0, 0.0])).tolist() == [0.5, math.inf]


def test_where_nothing_can_be_kept_it_is_compiled_all_the_same(monkeypatch: Any) -> None:
    njit, asked = tamp.compiled.njit, []

    def nowhere(cache: bool = False, **options: Any) -> Any:
        asked.append(cache)
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return njit(**options)

    monkeypatch.setattr(tamp.compiled, "njit", nowhere)
    assert compiled(_reciprocals)(np.array([4.0])).tolist() == [0.25]
    assert asked == [True, False]
