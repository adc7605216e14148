"""What decides results: the versions of the program, of Python and of the libraries; and how to install what lacks."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version
from itertools import chain

DISTRIBUTION = "tabletop-tamp"
DISTRIBUTIONS = (
    DISTRIBUTION, "numpy", "numba", "ompl", "pin", "coal", "pybullet", "python-fcl", "scipy", "toppra", "trimesh",
    "up-fast-downward",
)  # fmt: skip


@cache
def _installed() -> tuple[tuple[str, str], ...]:
    return tuple((name, _version(name)) for name in DISTRIBUTIONS)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"


def versions() -> dict[str, str]:
    """Distribution name -> version, "absent" where it is not installed; nothing is imported."""
    return {"python": platform.python_version(), **dict(_installed())}


def needs(extra: str) -> tuple[str, ...]:
    """What an extra of this program consists of, as requirements; empty where the program is not installed.

    Another extra of this program that it names is given by what that consists of: pip may not know the program's name.
    """
    own = (what for what, among in _extras() if among == extra)
    parts = ((what, re.fullmatch(rf"{DISTRIBUTION}\[([^\]]*)\]", what)) for what in own)
    return tuple(
        one
        for what, inner in parts
        for one in (chain(*map(needs, re.split(r"\s*,\s*", inner[1]))) if inner else (what,))
    )


def _extras() -> Iterator[tuple[str, str]]:
    """Each requirement of an extra with the extra's name."""
    try:
        requirements = requires(DISTRIBUTION) or ()
    except PackageNotFoundError:
        return
    for requirement in requirements:
        found = re.fullmatch(r"([^;]*?)\s*;.*extra == ['\"]([^'\"]+)['\"]", requirement)
        if found:
            yield found[1], found[2]


def how_to_install(extra: str) -> str:
    """The command that brings what an extra consists of, however this program itself was installed."""
    return f"pip install {' '.join(map(repr, needs(extra)))}"
