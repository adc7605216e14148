"""Install the wheel for the other Pythons that are here, each into a fresh environment, and solve a task with it.

All of it happens in an empty folder, so that nothing but what was installed is imported.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

VERSIONS = ("3.10", "3.12")
"""Supported Pythons beside that which everything else runs on: the oldest, and one for which PyBullet has no wheels."""

TASK = Path("scenarios/one_object.yaml")
FREE = ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONHOME")
"""Variables that would let a checkout or another environment be seen."""


def interpreters(version: str) -> Iterator[Path]:
    """Where a Python may be: on PATH, then among pyenv's."""
    if found := shutil.which(f"python{version}"):
        yield Path(found)
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    yield from sorted(root.glob(f"versions/{version}.*/bin/python{version}"))


def works(python: Path, version: str) -> bool:
    """Whether it is that Python: a stand-in of pyenv's is on PATH also where nothing is behind it."""
    said = subprocess.run(
        [python, "-c", "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"],
        capture_output=True, text=True,
    )  # fmt: skip
    return said.stdout.strip() == version


def run(folder: Path, *command: str | Path) -> str:
    """What a command prints in a folder; where it fails, that is shown and everything ends."""
    environment = {name: value for name, value in os.environ.items() if name not in FREE}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def tried(python: Path, version: str, wheel: Path) -> str:
    """Install and solve; what came of it, in a line.

    Where PyBullet has no wheels, MuJoCo stands in. The Panda's meshes are missing too, so another arm does the work.
    """
    has_bullet = tuple(map(int, version.split("."))) < (3, 12)
    extra, robot = ("", ()) if has_bullet else ("[ur5e]", ("--robot", "ur5e_2f85"))
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run(folder, python, "-m", "venv", "environment")
        binaries = folder / "environment" / "bin"
        run(folder, binaries / "pip", "install", "--quiet", "--no-compile", f"{wheel}{extra}")
        installed = time.monotonic()
        shutil.copy(TASK, folder)
        said = run(folder, binaries / "tamp", "--version").strip()
        run(folder, binaries / "tamp", "doctor")
        run(folder, binaries / "tamp", "plan", TASK.name, *robot, "-o", "plan.json")
        run(folder, binaries / "tamp", "solve", TASK.name, *robot, "--output", "runs")
        has = run(folder, binaries / "python", "-c", "from tamp.execution.simulators import DEFAULT; print(DEFAULT)")
        ended = time.monotonic()
    return f"{said} solves in {has.strip()}: {installed - began:.0f} s to install, {ended - installed:.0f} s to run"


def main(folder: Path, versions: Sequence[str] = VERSIONS) -> None:
    """Try the wheel in a folder with each of the Pythons."""
    (wheel,) = folder.resolve().glob("*.whl")
    for version in versions:
        python = next((python for python in interpreters(version) if works(python, version)), None)
        told = "not here, not tried" if python is None else tried(python, version, wheel)
        print(f"Python {version}: {told}", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
