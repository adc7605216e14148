"""The results file: one JSON line a result, appended whole or not at all, by one batch at a time."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from types import TracebackType

from tamp.errors import TampError
from tamp.results import Result, read_results, to_json


class Journal:
    """A results.jsonl open for appending; use it as a context manager.

    A last line that a crash has cut off is removed on opening; its task then counts as not run.

    Raises:
        TampError: on opening, where another batch writes to the file, or where it cannot be written or read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        except OSError as error:
            raise TampError(f"{path}: cannot be written: {error.strerror}") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(self._file)
            raise TampError(f"{path}: another batch is writing to it; wait for it or choose another --output") from None
        self._cut_torn_line()

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._file)

    def results(self) -> tuple[Result, ...]:
        """What the file holds."""
        return read_results(self._path)

    def clear(self) -> None:
        """Forget everything."""
        os.ftruncate(self._file, 0)

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
