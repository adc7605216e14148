"""Temporary files of workers and server: in the data folder, and gone with the process, however it ends.

Beside them a lock that says whether any of them is at work.
"""

from __future__ import annotations

import fcntl
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tamp.errors import TampError

LOCK = ".lock"
AT_WORK = ".at-work"


@contextmanager
def at_work(data: Path) -> Iterator[None]:
    """A server or worker is at work in a data folder as long as the block runs; it begins when nobody is `alone`."""
    with (data / AT_WORK).open("a") as file:
        fcntl.flock(file, fcntl.LOCK_SH)
        yield


@contextmanager
def alone(data: Path) -> Iterator[None]:
    """No server and no worker is at work in a data folder as long as the block runs.

    Raises:
        TampError: where one is.
    """
    with (data / AT_WORK).open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise TampError(
                f"{data}: a server or worker of this contest is at work, by the rules as they were when it began; "
                "stop all of them first. Nothing was changed"
            ) from None
        yield


@contextmanager
def scratch_folder(data: Path) -> Iterator[Path]:
    """An empty folder for temporary files of this process; what killed processes left beside it is removed.

    A living process holds the lock in its folder; the kernel takes it from a dead one.

    Args:
        data: the service's folder.
    """
    root = data / "scratch"
    root.mkdir(exist_ok=True)
    with (root / LOCK).open("w") as all_of_them:
        fcntl.flock(all_of_them, fcntl.LOCK_EX)  # nobody looks at a folder that is not locked yet
        for left in root.iterdir():
            if left.is_dir() and _abandoned(left):
                shutil.rmtree(left, ignore_errors=True)
        folder = Path(tempfile.mkdtemp(dir=root))
        held = (folder / LOCK).open("w")
        fcntl.flock(held, fcntl.LOCK_EX)
    with held:
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def unfinished(data: Path, place: Path) -> Iterator[Path]:
    """Where to write a file that takes its place when it is whole; no other process writes there.

    Args:
        data: the service's folder.
        place: where the file is to be, on the same file system.
    """
    place.parent.mkdir(parents=True, exist_ok=True)
    with scratch_folder(data) as folder:
        part = folder / place.name
        yield part
        part.replace(place)


def _abandoned(folder: Path) -> bool:
    try:
        with (folder / LOCK).open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
