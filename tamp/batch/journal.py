"""The results file: one JSON line a result, appended whole or not at all, by one batch at a time."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType

from tamp.errors import TampError
from tamp.results import Result, read_results, to_json
from tamp.task.files.regular_file import unlinked


class Journal:
    """A results.jsonl open for appending; use it as a context manager.

    A last line that a crash has cut off is removed on opening; its task then counts as not run. A link is not followed:
    what it leads to would lose its last line. Nobody waits for a pipe.

    Raises:
        TampError: on opening, where another batch writes to the file, or where it cannot be written or read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if path.is_symlink():
                raise OSError(errno.ELOOP, "it is a link; choose another --output")
            if path.exists() and not path.is_file():
                raise OSError(errno.EINVAL, "it is no regular file; choose another --output")
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW, 0o666)
        except OSError as error:
            raise TampError(f"{path}: cannot be written: {error.strerror}") from error
        try:
            self._lock(self._file)
        except TampError:
            os.close(self._file)
            raise
        self._cut_torn_line()

    def _lock(self, file: int) -> None:
        """Be the one who writes; the file that was opened may have been replaced while we came."""
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            mine = os.path.samestat(os.fstat(file), self._path.stat())
        except OSError:
            mine = False
        if not mine:
            raise TampError(f"{self._path}: another batch is writing to it; wait for it or choose another --output")

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._file)

    def results(self) -> tuple[Result, ...]:
        """What the file holds."""
        return read_results(self._path)

    def keep(self, results: Iterable[Result]) -> None:
        """Leave only these in the file, whole or not at all.

        Raises:
            TampError: where they cannot be written; the file is then as it was.
        """
        new = self._path.with_suffix(".new")
        try:
            file = os.open(unlinked(new), os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_NOFOLLOW, 0o666)
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with os.fdopen(os.dup(file), "wb") as lines:
                lines.writelines(to_json(result).encode() + b"\n" for result in results)
            os.fsync(file)
            new.replace(self._path)
        except OSError as error:
            raise TampError(f"{self._path}: cannot be written: {error.strerror}; it is as it was") from error
        os.close(self._file)
        self._file = file

    def append(self, result: Result) -> None:
        """Write one line through to the disk; what a full disk cuts off is taken back.

        Raises:
            TampError: where the line cannot be written; what was written before stays.
        """
        line = to_json(result).encode() + b"\n"
        before = os.fstat(self._file).st_size
        try:
            if os.write(self._file, line) != len(line):
                raise OSError(0, "the disk is full")
            os.fsync(self._file)
        except OSError as error:
            os.ftruncate(self._file, before)
            raise TampError(f"{self._path}: {error.strerror}; the results before this one are kept") from error

    def _cut_torn_line(self) -> None:
        data = self._path.read_bytes()
        os.ftruncate(self._file, data.rfind(b"\n") + 1)
