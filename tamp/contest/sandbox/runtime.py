"""What a solution needs to run: the interpreter, system libraries, the Standard API, the libraries offered."""

from __future__ import annotations

import json
import re
import site
import sys
import sysconfig
from collections.abc import Sequence
from functools import lru_cache
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from importlib.resources import files
from pathlib import Path

from tamp.contest.sandbox.isolation import ENVIRONMENT, Mount, Room, Sandbox
from tamp.errors import TampError

SITE = "/site"
SOLUTION = "/solution"
MODELS = "/models"
OWN = "tabletop-tamp"
SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache")
API = ("__init__.py", "errors.py", "contest/__init__.py", "contest/api", "contest/adapters")
"""What of this program every solution sees."""

LINKS = (
    ("/dev/fd", "/proc/self/fd"),
    ("/dev/stdin", "/proc/self/fd/0"),
    ("/dev/stdout", "/proc/self/fd/1"),
    ("/dev/stderr", "/proc/self/fd/2"),
    ("/dev/shm", "/tmp"),
)
"""Links of /dev that programs expect: semaphores and shared memory, as `multiprocessing` has them, are files of a
solution's own, and count as the others do.
"""

TASKS = "scenarios"
"""What of it no solution sees: tasks, with where everything is."""

START = (
    "import sys; sys.path.remove(''); import json, os, site; path, given = sys.argv[1:]; del sys.argv[1:]; "
    "path = json.loads(path); [*map(site.addsitedir, path)]; os.environ.update(PYTHONPATH=os.pathsep.join(path), "
    "OPENBLAS_NUM_THREADS='1', OMP_NUM_THREADS='1', MKL_NUM_THREADS='1'); "
    "from tamp.contest.api.host import main; sys.exit(main(given))"
)
"""Linear algebra runs on one thread unless a solution asks for more: libraries would start as many threads as the
machine has processors, each of which counts, so that what a solution may do would depend on the machine. A Python that
a solution starts finds the same libraries, also where it is given this one's options, as some libraries do."""


def interpreter() -> str:
    """The Python that solutions are run by: this one, without its environment."""
    return str(Path(sys.executable).resolve())


def start(sandbox: Sandbox, given: str) -> list[str]:
    """The command inside a sandbox that begins a solution; `tamp.contest.api.host` says what is given."""
    told = [f"{name}={value}" for name, value in ENVIRONMENT.items()]
    path = json.dumps(_search_path(sandbox))
    return ["/usr/bin/env", "-i", *told, interpreter(), "-s", "-S", "-c", START, path, given]


def make_room(solution: Path, models: Path, libraries: Sequence[str], scratch_mb: int) -> Room:
    """The room of a solution.

    Args:
        solution: folder of its package.
        models: folder of the meshes.
        libraries: distributions that are offered, with all that they need; NumPy is always there.
        scratch_mb: size of its temporary folder [MiB].

    Raises:
        TampError: where a library is not installed.
    """
    links = tuple((path, str(Path(path).readlink())) for path in SYSTEM if Path(path).is_symlink())
    folders = [path for path in SYSTEM if Path(path).exists() and not Path(path).is_symlink()]
    base = str(Path(sys.base_prefix).resolve())
    if not any(base == path or base.startswith(f"{path}/") for path in folders):
        folders.append(base)
    mounts = [Mount(Path(path), path) for path in folders]
    own = sorted({Path(path).resolve() for path in [*site.getsitepackages([sys.base_prefix]), *_pure()]})
    hidden = tuple(str(path) for path in own if path.is_dir() and any(str(path).startswith(f"{f}/") for f in folders))
    shown = [*_library_mounts(("numpy", *libraries)), Mount(solution, SOLUTION), Mount(models, MODELS)]
    return Room((*mounts, *shown), hidden, (*links, *LINKS), scratch_mb)


def _pure() -> set[str]:
    return {sysconfig.get_path(kind) for kind in ("purelib", "platlib")}


@lru_cache(maxsize=4)
def _library_mounts(libraries: tuple[str, ...]) -> tuple[Mount, ...]:
    mounts: dict[str, Path] = {}
    for found in closure(libraries):
        if _parsed(found.name)[0] == OWN:
            continue
        tops = {file.parts[0] for file in found.files or ()} - {"..", "__pycache__"}
        for entry in sorted(tops):
            mounts[f"{SITE}/{entry}"] = Path(str(found.locate_file(entry)))
    root = Path(str(files("tamp")))
    whole = OWN in (_parsed(name)[0] for name in libraries)
    parts = sorted(p.name for p in root.iterdir() if p.name not in (TASKS, "__pycache__")) if whole else API
    mounts |= {f"{SITE}/tamp/{part}": (root / part).resolve() for part in parts}
    return tuple(Mount(path, target) for target, path in mounts.items() if path.exists())


def closure(libraries: Sequence[str]) -> list[Distribution]:
    """The distributions of names, such as "scipy" or "tabletop-tamp[perception]", and all that they need.

    Raises:
        TampError: where one that is named is not installed.
    """
    found: dict[str, Distribution] = {}
    seen: set[str] = set()
    wanted = [(name, True) for name in libraries]
    for text, named in wanted:
        if text in seen:
            continue
        seen.add(text)
        name, extras = _parsed(text)
        try:
            found[name] = distribution(name)
        except (PackageNotFoundError, ValueError):
            if named:
                raise TampError(
                    f"the library {text!r}, to be offered to solutions, is not installed; expected the name of a "
                    "distribution, without a version"
                ) from None
            continue  # needed on other machines or for other extras only
        for need in found[name].requires or ():
            requirement, _, marker = need.partition(";")
            extra = re.search(r"extra\s*==\s*['\"]([^'\"]+)", marker)
            if extra is None or extra[1] in extras:
                wanted.append((re.split(r"[^A-Za-z0-9_.,\[\]-]", requirement.strip(), maxsplit=1)[0], False))
    return list(found.values())


def _parsed(text: str) -> tuple[str, list[str]]:
    """The normal name of a distribution, and the extras that are asked for."""
    name, _, extras = text.rstrip("]").partition("[")
    return re.sub(r"[-_.]+", "-", name).lower(), [extra.strip() for extra in extras.split(",") if extra]


def _search_path(sandbox: Sandbox) -> list[str]:
    """Where a solution's Python looks for the Standard API and the libraries offered."""
    if sandbox.isolates:
        return [SITE]
    return [str(Path(str(files("tamp"))).parent), *sorted(_pure())]
