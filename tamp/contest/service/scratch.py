"""Temporary files of workers and server: in the data folder, and gone with the process, however it ends."""

from __future__ import annotations

import fcntl
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LOCK = ".lock"


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
