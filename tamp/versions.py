"""What decides results: the versions of the program, of Python and of the libraries."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import distributions

DISTRIBUTIONS = (
    "tabletop-tamp", "numpy", "ompl", "pin", "coal", "pybullet", "python-fcl", "scipy", "toppra", "trimesh",
    "up-fast-downward",
)  # fmt: skip


@cache
def _installed() -> tuple[tuple[str, str], ...]:
    found = {d.metadata["Name"].lower().replace("_", "-"): d.version for d in distributions()}
    return tuple((name, found.get(name, "absent")) for name in DISTRIBUTIONS)


def versions() -> dict[str, str]:
    """Distribution name -> version, "absent" where it is not installed; nothing is imported."""
    return {"python": platform.python_version(), **dict(_installed())}
