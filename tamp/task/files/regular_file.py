"""Files in a stranger's folder: what is read is regular and no larger than it may be, what is written stays there."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from stat import S_ISREG

LARGEST = 256 * 2**20
"""What any file of a plan or a run may have at most [bytes]."""


def read_regular(path: Path, most: int = LARGEST) -> bytes:
    """All of a regular file.

    A pipe would keep whoever opens it waiting, and a device may never end: neither is read.

    Args:
        path: the file, or a link to it.
        most: how large it may be [bytes].

    Raises:
        OSError: where there is none, or it is something else, or larger; `strerror` says which.
    """
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(descriptor, "rb") as file:
        kind = os.fstat(descriptor).st_mode
        if not S_ISREG(kind):
            raise OSError(errno.EINVAL, "it is a pipe or a device, no regular file", str(path))
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"larger than {most} bytes, the most that it may have", str(path))
    return data


def followed(path: Path) -> Path:
    """The absolute path that a path leads to, all links followed; links in a circle are left as they are."""
    return Path(os.path.realpath(path))


def unlinked(path: Path) -> Path:
    """The same path, and no link is there any more: what is written to it is not written elsewhere.

    Raises:
        OSError: where there is a link that cannot be taken away.
    """
    if path.is_symlink():
        path.unlink()
    return path
