"""Loops over small arrays, compiled to machine code (Numba): where numpy would spend its time on calls, not on numbers.

A function is compiled when it is first called in the first process that does, and kept on disk beside the module, or in
the user's cache where that cannot be written. What such a function calls belongs into its own module: a change
elsewhere would not be seen. Hand it fresh arrays in C order: for others, and read-only ones, it is compiled once more.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile a function of numbers and arrays; division by zero gives infinity, as in numpy."""
    try:
        return cast(Function, njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # nowhere to keep it
        return cast(Function, njit(error_model="numpy")(function))
