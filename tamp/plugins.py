"""What users bring from outside the package: entry points of installed packages, folders that the environment names.

Two ways to add a domain or a sampler without touching this package, as for robots:

- a package declares an entry point in one of the groups `tamp.domains`, `tamp.samplers`;
- the environment variables TAMP_DOMAINS and TAMP_SAMPLERS list folders, separated as in PATH, with packages or modules.

A package's simulators, strategies and searches are found by `tamp.simulators`, `tamp.strategies` and `tamp.searches`;
they have no variable.

All are the user's own choice, so what they bring counts as installed. Nothing here imports what it finds.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Literal

from tamp.errors import TampError, told

Kind = Literal["domains", "samplers", "simulators", "strategies", "searches"]


def folders(kind: Kind) -> tuple[Path, ...]:
    """The folders that the environment names for a kind, in their order.

    Raises:
        TampError: where one of them is not there.
    """
    variable = f"TAMP_{kind.upper()}"
    named = tuple(Path(text).expanduser() for text in os.environ.get(variable, "").split(os.pathsep) if text)
    for folder in named:
        if not folder.is_dir():
            raise TampError(f"{variable} names {folder}, which is no folder")
    return tuple(folder.resolve() for folder in named)


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


def make_importable(kind: Kind) -> None:
    """Let packages and modules in the folders of a kind be imported by name, behind all that is installed."""
    for folder in folders(kind):
        if str(folder) not in sys.path:
            sys.path.append(str(folder))


def imported(module: str, what: str, wrong: type[TampError]) -> ModuleType:
    """A module of a user's.

    Args:
        module: its name.
        what: it is imported for, as sentences begin.
        wrong: the error that is raised.

    Raises:
        TampError: `wrong`, where there is no such module or where it fails, with the line; its own TampErrors pass.
    """
    try:
        return importlib.import_module(module)
    except TampError:
        raise
    except (Exception, SystemExit) as error:  # a script without a guard ends itself, not this program
        missing = error.name if isinstance(error, ModuleNotFoundError) else None
        if missing is not None and f"{module}.".startswith(f"{missing}."):
            raise wrong(f"{what}: there is no module {missing!r}") from None
        raise wrong(f"{what}: {module!r} cannot be imported: {told(error)}") from error
