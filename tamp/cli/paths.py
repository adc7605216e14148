"""Where something is written, as a kind of value: what cannot be written is refused before any work begins."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path

from tamp.task.files.regular_file import followed

PLAN = (r'\{\s*"format"\s*:\s*"tamp-plan"', "a plan")
DATA = (r'\[|(?!\{"task": "[^"]*", "seed": )\{\s*["}]', "JSON")
TABLE = (r"task,", "a table of results")
PAGE = (r"<", "a page")
"""How what is written begins, and what it is: a file that begins otherwise is somebody's, and is not replaced."""

BEGINNING = 200


def output_file(form: tuple[str, str] | None = None) -> Callable[[str], Path]:
    """A file that can be written; one that is there already must hold `form` or nothing."""

    def path(text: str) -> Path:
        found = _writable(text, folder=False)
        if form is not None and found.is_file():
            with found.open("rb") as file:
                begun = file.read(BEGINNING).decode("utf-8", errors="replace").lstrip()
            if begun and not re.match(form[0], begun):
                raise argparse.ArgumentTypeError(f"{text} is there already and is not {form[1]}; choose another name")
        return found

    return path


def output_folder(text: str) -> Path:
    """A folder that is there, or can be made."""
    return _writable(text, folder=True)


def output_path(text: str) -> Path:
    """A file or a folder that can be written, whatever the command makes of it."""
    return _writable(text, folder=None)


def distinct(paths: Iterable[Path]) -> list[Path]:
    """Paths without those that lead where an earlier one does."""
    found: dict[Path, Path] = {}
    for path in paths:
        found.setdefault(followed(path), path)
    return list(found.values())


def _writable(text: str, *, folder: bool | None) -> Path:
    path = Path(text)
    try:
        nearest = next(place for place in (path, *path.parents, Path("/")) if place.exists())
        if nearest == path and folder is not None and path.is_dir() != folder:
            why = f"it is {'no' if folder else 'a'} folder"
        elif nearest != path and not nearest.is_dir():
            why = f"{nearest} is no folder"
        else:
            why = "" if os.access(nearest, os.W_OK) else f"{nearest} does not allow it"
    except (OSError, ValueError) as error:  # too long, not to be looked into, a zero byte
        why = getattr(error, "strerror", None) or str(error)
    if why:
        raise argparse.ArgumentTypeError(f"{text} cannot be written: {why}")
    return path
