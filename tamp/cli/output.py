"""Standard output, which carries what was asked for and nothing else; and what several commands write alike."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any, TextIO

from tamp.errors import TampError

STDOUT = 1


@contextmanager
def asked_only() -> Iterator[TextIO]:
    """Give standard output as it was; whoever else prints while the block runs, prints to standard error.

    Samplers and native libraries print where they like: Python's `sys.stdout` and file descriptor 1 both lead to
    standard error within the block, also in the processes that it starts.
    """
    asked = sys.stdout
    asked.flush()
    with redirect_stdout(sys.stderr):
        if not _is_stdout(asked):  # somebody in this process reads it: there is no descriptor to keep clean
            yield asked
            return
        kept = os.dup(STDOUT)
        os.dup2(2, STDOUT)
        try:
            with os.fdopen(os.dup(kept), "w", encoding=asked.encoding, errors=asked.errors, buffering=1) as out:
                _keep_from_children(out)
                yield out
        finally:
            os.dup2(kept, STDOUT)
            os.close(kept)


def _keep_from_children(out: TextIO) -> None:
    """A process that a sampler forks goes on in the middle of a command: what it has to say nobody asked for."""

    def keep() -> None:
        if not out.closed:
            os.dup2(os.open(os.devnull, os.O_WRONLY), out.fileno())

    os.register_at_fork(after_in_child=keep)


def _is_stdout(stream: TextIO) -> bool:
    try:
        return stream.fileno() == STDOUT
    except (OSError, ValueError):
        return False


def write_json(options: argparse.Namespace, data: Any) -> None:
    """Write data to the file of `--json`; "-" is standard output, no file writes nothing.

    Raises:
        TampError: where the file cannot be written.
    """
    if options.json is None:
        return
    write_asked(options, options.json, json.dumps(data, indent=1, allow_nan=False) + "\n")


def write_asked(options: argparse.Namespace, path: Path, text: str) -> None:
    """Write what an option asks for to its file; "-" is standard output. Raises TampError as `write_text` does."""
    if str(path) == "-":
        options.out.write(text)
    else:
        write_text(path, text)


def to_stdout(options: argparse.Namespace) -> bool:
    """Whether the JSON, or the table, goes to standard output, so that nothing else should."""
    return "-" in (str(options.json), str(getattr(options, "csv", None)))


def write_text(path: Path, text: str) -> None:
    """Write a file, folders and all.

    Raises:
        TampError: where it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise TampError(f"{path}: cannot be written: {error.strerror}") from error
