"""Numerical libraries on one thread: the matrices of planning are small, and threads that wait for work burn time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def one_thread() -> Iterator[None]:
    """Let linear algebra run on one thread within; afterwards it is as it was, for the caller's own work.

    The setting is the process's own, so what other threads compute meanwhile runs on one thread each as well.
    """
    import numpy  # noqa: F401  # what is not loaded cannot be limited
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1, user_api="blas"):
        yield
