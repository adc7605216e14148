"""What decides results: the versions of the program, of Python and of the libraries; and how to install what lacks."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version

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
    """What an extra of this program consists of, as requirements; empty where the program is not installed."""
    try:
        requirements = requires(DISTRIBUTION) or ()
    except PackageNotFoundError:
        return ()
    parted = (requirement.partition(";") for requirement in requirements)
    return tuple(what.strip() for what, _, where in parted if where.replace("'", '"').endswith(f'extra == "{extra}"'))


def how_to_install(extra: str) -> str:
    """The command that brings what an extra consists of, however this program itself was installed."""
    return f"pip install {' '.join(map(repr, needs(extra)))}"
