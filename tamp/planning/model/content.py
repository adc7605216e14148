"""What a value without a hash consists of, so that equal ones can be told: arrays, and containers of whatever else."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable
from typing import Any

import numpy as np


def content(value: Any) -> Hashable | None:
    """A key that two values share only where they are of one type and equal; None where nobody can tell.

    Arrays are compared by their numbers, lists, tuples, dictionaries, sets and dataclasses item by item.
    """
    try:
        return _key(value)
    except (TypeError, RecursionError):
        return None


def own_copy(value: Any) -> Any:
    """A value as it is now, whatever whoever gave it does with it later: copies of arrays and of containers in it."""
    kind = type(value)
    if kind in (np.ndarray, set, bytearray):
        return value.copy()
    if kind is dict:
        return {name: own_copy(item) for name, item in value.items()}
    if kind in (list, tuple):
        return kind(map(own_copy, value))
    if isinstance(value, tuple) and hasattr(kind, "_make"):  # of collections.namedtuple
        return kind._make(map(own_copy, value))
    return value


def _key(value: Any) -> Hashable:
    """As `content`; raises TypeError where nobody can tell."""
    kind = type(value)
    if isinstance(value, np.ndarray):
        if value.dtype.hasobject:
            return kind, value.shape, *map(_key, value.ravel().tolist())
        return kind, value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, tuple | list):
        return kind, *map(_key, value)
    if isinstance(value, dict):
        return kind, frozenset((_key(name), _key(item)) for name, item in value.items())
    if isinstance(value, set | bytearray):
        return kind, frozenset(value) if isinstance(value, set) else bytes(value)
    if dataclasses.is_dataclass(kind) and kind.__hash__ is None:
        fields = [field.name for field in dataclasses.fields(value) if field.compare]
        return kind, *(_key(getattr(value, name)) for name in fields)
    hash(value)
    return kind, value
