"""What users bring from outside the package: entry points of installed packages, and folders that TAMP_PATH names.

Two ways to add a domain, robot or sampler without touching this one:

- a package declares an entry point in one of the groups `tamp.domains`, `tamp.robots`, `tamp.samplers`;
- the environment variable TAMP_PATH lists folders, each with any of the subfolders `domains`, `robots`, `samplers`.

Both are the user's own choice, so what they bring counts as installed. Nothing here imports what it finds.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Literal

from tamp.errors import TampError

Kind = Literal["domains", "robots", "samplers"]

VARIABLE = "TAMP_PATH"
"""Folders separated as in PATH."""


def folders(kind: Kind) -> tuple[Path, ...]:
    """The subfolders of a kind in the folders of TAMP_PATH, in their order.

    Raises:
        TampError: where TAMP_PATH names a folder that is not there.
    """
    roots = [Path(text).expanduser() for text in os.environ.get(VARIABLE, "").split(os.pathsep) if text]
    for root in roots:
        if not root.is_dir():
            raise TampError(f"{VARIABLE}: there is no folder {str(root)!r}")
    return tuple(found for root in roots if (found := (root / kind).resolve()).is_dir())


def addresses(kind: Kind) -> Mapping[str, str]:
    """Name -> "package.module" or "package.module:NAME" of the entry points `tamp.KIND`, sorted by name.

    Raises:
        TampError: where two packages give the same name to different things.
    """
    found: dict[str, EntryPoint] = {}
    for entry in sorted(entry_points(group=f"tamp.{kind}"), key=lambda entry: (entry.name, entry.value)):
        known = found.setdefault(entry.name, entry)
        if known.value != entry.value:
            raise TampError(f"entry points tamp.{kind}: {entry.name!r} is both {known.value} and {entry.value}")
    return {name: entry.value for name, entry in found.items()}


def data_folders(kind: Kind, marker: str) -> Mapping[str, Path]:
    """Name -> the folder that holds a file `marker`: each in TAMP_PATH, and those that entry points name as packages.

    Args:
        kind: of what is looked for.
        marker: the file that a folder must have, such as "robot.yaml".

    Raises:
        TampError: where an entry point names a package that is not there.
    """
    found: dict[str, Path] = {}
    for name, address in addresses(kind).items():
        folder = _package_folder(address)
        if folder is None:
            raise TampError(f"entry point tamp.{kind}: {name} = {address!r}: there is no such package")
        if (folder / marker).is_file():
            found[name] = folder
    for parent in reversed(folders(kind)):  # the first of several that have a name wins, and wins over entry points
        found |= {path.parent.name: path.parent for path in sorted(parent.glob(f"*/{marker}"))}
    return dict(sorted(found.items()))


def make_importable(kind: Kind) -> None:
    """Let packages and modules in the folders of TAMP_PATH be imported by name, behind all that is installed."""
    for folder in folders(kind):
        if str(folder) not in sys.path:
            sys.path.append(str(folder))


def _package_folder(address: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(address.partition(":")[0])
    except ModuleNotFoundError:
        return None
    places = (spec.submodule_search_locations if spec is not None else None) or ()
    return next((Path(place) for place in places), None)
