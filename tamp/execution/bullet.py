"""PyBullet, imported without the line that it prints to standard output when it loads."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _silent_output() -> Iterator[None]:
    """Standard output leads nowhere inside, for C code too, which keeps a buffer of its own."""
    sys.stdout.flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
        ctypes.CDLL(None).fflush(None)
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


with _silent_output():
    import pybullet

__all__ = ["pybullet"]
