"""Are two outputs the same, but for rounding, arrays and all?"""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

ROUNDING = 1e-9
"""Sums in another order differ by less: what a sampler remembers of one call may reach the next so far."""


def same(a: Any, b: Any) -> bool:
    """Whether two values are equal in type and content; dataclasses and sequences by their parts."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.shape == b.shape and bool(np.allclose(a, b, rtol=ROUNDING, atol=ROUNDING, equal_nan=True))
    if isinstance(a, float):
        return math.isclose(a, b, rel_tol=ROUNDING, abs_tol=ROUNDING)
    if is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(value, b[key]) for key, value in a.items())
    return a is b or bool(a == b)
