"""What several commands print and write alike."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from tamp.errors import TampError


def write_json(path: Path | None, data: Any) -> None:
    """Write data as JSON; "-" is standard output, None writes nothing.

    Raises:
        TampError: where the file cannot be written.
    """
    if path is None:
        return
    text = json.dumps(data, indent=1, allow_nan=False) + "\n"
    if str(path) == "-":
        sys.stdout.write(text)
    else:
        write_text(path, text)


def to_stdout(path: Path | None) -> bool:
    """Whether the JSON goes to standard output, so that nothing else should."""
    return str(path) == "-"


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
