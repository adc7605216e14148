"""The house's rules: who may import whom, where heavy libraries live, and what stays light."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

TAMP = Path(__file__).parents[1] / "tamp"

# Room -> the rooms it may import. `planning` and `world` never see each other: they meet in a sampler of `streams`.
ALLOWED = {
    "errors": set(),
    "versions": set(),
    "results": {"errors"},
    "task": {"errors"},
    "language": {"errors"},
    "planning": {"language", "errors"},
    "world": {"task", "errors"},
    "scoring": {"results", "task", "errors"},
    "formats": {"task", "errors"},
    "robots": set(),
    "scenarios": {"task", "errors"},
    "checking": {"task", "language", "errors"},
    "execution": {"world", "task", "errors"},
    "streams": {"world", "task", "errors"},
    "domains": {"streams", "world", "planning", "language", "task", "errors"},
    "generate": {"execution", "scenarios", "scoring", "world", "task", "errors"},
    "report": {"execution", "world", "scoring", "results", "versions", "task", "errors"},
    "pipeline": {
        "domains", "streams", "planning", "world", "checking", "execution", "scoring", "results", "versions", "task",
        "errors",
    },
    "batch": {"pipeline", "results", "versions", "task", "errors"},
    "conformance": {"domains", "streams", "planning", "language", "pipeline", "world", "task", "errors"},
    "arguments": {"errors"},
    "cli": {"arguments", "errors"},
    "commands": {
        "cli", "batch", "report", "conformance", "pipeline", "formats", "generate", "scenarios", "domains", "planning",
        "language", "world", "checking", "execution", "scoring", "results", "versions", "task", "errors",
    },
}  # fmt: skip

# Heavy library -> the modules that may import it.
HOMES = {
    "coacd": {"task.decompose"},
    "distributed": {"batch.dask"},
    "submitit": {"batch.slurm"},
    "imageio_ffmpeg": {"report.images"},
    "jinja2": {"report.page"},
    "matplotlib": {"report.plots"},
    "coal": {"world.solid"},
    "fcl": {"checking.distances"},
    "numba": set(),
    "ompl": {"world.ompl_search"},
    "PIL": {"report.images"},
    "pinocchio": {
        "world.actor", "world.arena", "world.chain", "world.hand", "world.robot_model", "world.self_collision",
    },
    "pybullet": {"execution.bullet"},
    "pydantic": {"task.explain", "task.load", "task.schema"},
    "rich": {"commands.batches", "commands.compare", "results"},
    "shtab": {"commands.completion"},
    "scipy": {"checking.distances", "checking.statics", "scoring.assignment", "task.mesh", "world.seeds"},
    "toppra": {"world.timing"},
    "viser": {"report.viewer"},
    "trimesh": {"task.meshfile", "scenarios.make_objects"},
}  # fmt: skip

CONTENT = ("streams", "domains", "robots", "scenarios")


def _modules() -> dict[str, Path]:
    """Module name without `tamp.` -> file; the content folders through their links."""
    found = {}
    for folder in (TAMP, *(TAMP / name for name in CONTENT)):
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(TAMP).with_suffix("").parts
            found[".".join(parts).removesuffix("__init__").removesuffix(".")] = path
    return found


MODULES = _modules()


def _imports(path: Path) -> Iterator[str]:
    """Every module that a file imports, at its top or inside a function, for types or at run time."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_every_room_is_known() -> None:
    assert {name.partition(".")[0] for name in MODULES} - {""} == set(ALLOWED)


@pytest.mark.parametrize("module", [name for name in MODULES if name])
def test_imports_point_one_way(module: str) -> None:
    room = module.partition(".")[0]
    seen = {name.split(".")[1] for name in _imports(MODULES[module]) if name.startswith("tamp.")}
    assert seen - {room} <= ALLOWED[room], f"tamp.{module} must not import {sorted(seen - {room} - ALLOWED[room])}"


def test_the_rooms_have_an_order() -> None:
    """The rules themselves leave no way round in a circle."""
    left = {room: set(below) for room, below in ALLOWED.items()}
    while left:
        free = {room for room, below in left.items() if not below & left.keys()}
        assert free, f"circle among {sorted(left)}"
        left = {room: below for room, below in left.items() if room not in free}


@pytest.mark.parametrize("library", HOMES)
def test_a_heavy_library_has_few_homes(library: str) -> None:
    homes = {name for name, path in MODULES.items() if any(i.partition(".")[0] == library for i in _imports(path))}
    assert homes <= HOMES[library]


@pytest.mark.parametrize("module", MODULES)
def test_content_is_imported_through_tamp(module: str) -> None:
    assert not {name.partition(".")[0] for name in _imports(MODULES[module])} & set(CONTENT)


def _loaded_by(statement: str) -> set[str]:
    """Top-level names of all modules that a fresh interpreter has after a statement."""
    code = f"{statement}\nimport sys\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=TAMP.parent)
    return set(done.stdout.splitlines()[-1].split())


HEAVY = {*HOMES, "numpy", "yaml"}


def test_importing_tamp_loads_no_library() -> None:
    assert not _loaded_by("import tamp") & HEAVY


def test_help_loads_no_library() -> None:
    assert not _loaded_by("import tamp.cli\ntry: tamp.cli.main(['--help'])\nexcept SystemExit: pass") & HEAVY


def test_reading_a_task_loads_no_native_geometry() -> None:
    native = set(HOMES) - {"pydantic", "rich"}
    assert not _loaded_by("import tamp\ntamp.load_task('scenarios/swap.yaml')") & native


def test_every_public_name_is_there() -> None:
    import tamp

    assert all(hasattr(tamp, name) for name in tamp.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = tamp.nonsense
