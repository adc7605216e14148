"""What a solution meets where its sandbox ends: made as if it were not there, where Python asks, or said in words."""

from __future__ import annotations

import errno
import selectors
import socket
from collections.abc import Iterator, Mapping
from types import MappingProxyType

REFUSED = (
    "the sandbox has no network, Unix sockets with a connection only, no descriptors sent over them, no memory without "
    "a name, and locks on whole files only (flock; for SQLite, nolock=1)"
)

MET: Mapping[int, str] = MappingProxyType(
    {
        errno.EPERM: REFUSED,
        errno.EROFS: "only /tmp can be written to",
        errno.ENOSPC: "what is written to /tmp is limited by 'scratch_mb'",
        errno.EFBIG: "what is written to /tmp is limited by 'scratch_mb'",
        errno.EMFILE: "a process may hold 256 files open",
    }
)
"""Number of an error of the system's -> what it comes from in a sandbox."""

DEEPEST = 20
"""Causes of causes that are looked at."""


class Absent:
    """An attribute that is not there, whoever asks; Python and libraries then do without it."""

    def __get__(self, owner: object, kind: type) -> object:
        raise AttributeError(f"is not there: {REFUSED}")


def hide_refused() -> None:
    """Have Python's own library do without what the filter of system calls refuses, where it knows a way.

    `asyncio` waits by `poll`, and joins what is written in pieces; `multiprocessing` has no fork server, to which
    descriptors would be sent.
    """
    selectors.DefaultSelector = selectors.PollSelector  # type: ignore[assignment,misc]
    socket.socket.sendmsg = Absent()  # type: ignore[assignment,method-assign]


def met(error: BaseException) -> str:
    """What of the sandbox is behind an exception, to be said after its own words; else nothing."""
    for cause in _causes(error):
        if isinstance(cause, socket.gaierror) or type(cause).__module__ == "sqlite3":
            return f"; {REFUSED}"
        if isinstance(cause, MemoryError):
            return "; memory is limited by 'memory_mb'"
        if isinstance(cause, OSError) and cause.errno is not None and cause.errno in MET:
            return f"; {MET[cause.errno]}"
    return ""


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """An exception, and those that it came of."""
    for _ in range(DEEPEST):
        if error is None:
            return
        yield error
        reason = getattr(error, "reason", None)  # as urllib's errors have it
        error = reason if isinstance(reason, BaseException) else error.__cause__ or error.__context__
