"""The house's rules: who may import whom, where heavy libraries live, and what stays light."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

TAMP = Path(__file__).parents[1] / "tamp"

# Room -> the rooms it may import. `planning` and `world` never see each other: they meet in a sampler of `streams`.
ALLOWED = {
    "errors": set(),
    "frozen": set(),
    "clock": set(),
    "compiled": set(),
    "threads": set(),
    "parent": set(),
    "speculation": {"clock", "parent", "errors"},
    "versions": set(),
    "plugins": {"errors"},
    "results": {"errors", "frozen"},
    "task": {"errors", "frozen"},
    "language": {"errors", "frozen"},
    "planning": {"clock", "language", "errors", "frozen"},
    "world": {"clock", "compiled", "task", "errors"},
    "scoring": {"results", "task", "errors", "frozen"},
    "formats": {"versions", "world", "task", "errors"},
    "perception": {
        "clock", "compiled", "plugins", "versions", "execution", "streams", "world", "task", "errors", "frozen",
    },
    "robots": set(),
    "scenarios": {"task", "errors"},
    "checking": {"compiled", "task", "language", "errors"},
    "execution": {"clock", "plugins", "versions", "world", "task", "errors", "frozen"},
    "streams": {"clock", "compiled", "execution", "world", "task", "errors"},
    "sampling": {"domains", "streams", "world", "task"},
    "domains": {"clock", "plugins", "streams", "world", "planning", "language", "task", "errors", "frozen"},
    "generate": {"execution", "scenarios", "scoring", "world", "task", "errors"},
    "report": {"execution", "world", "scoring", "results", "versions", "task", "errors"},
    "pipeline": {
        "clock", "domains", "streams", "planning", "language", "world", "checking", "execution", "perception",
        "scoring", "results", "speculation", "threads", "versions", "plugins", "task", "errors", "frozen",
    },
    "batch": {"clock", "parent", "pipeline", "results", "versions", "task", "errors"},
    "contest": {
        "clock", "perception", "execution", "scoring", "formats", "report", "pipeline", "results", "versions", "world",
        "task", "errors",
    },
    "conformance": {
        "checking", "clock", "domains", "execution", "streams", "planning", "language", "pipeline", "world", "threads",
        "task", "errors",
    },
    "__main__": {"cli"},
    "cli": {
        "clock", "batch", "contest", "report", "conformance", "pipeline", "formats", "generate", "scenarios", "domains",
        "planning", "language", "world", "checking", "execution", "perception", "scoring", "results", "versions",
        "parent", "plugins", "task", "errors",
    },
}  # fmt: skip

# Heavy library -> the modules that may import it.
HOMES = {
    "coacd": {"task.mesh.decompose"},
    "distributed": {"batch.dask"},
    "embreex": {"perception.rendering.raycast"},
    "submitit": {"batch.slurm"},
    "imageio_ffmpeg": {"report.rendering.images"},
    "fastapi": {f"contest.service.web.{name}" for name in ("app", "described", "guard", "uploads")},
    "jinja2": {"contest.service.web.pages", "report.page"},
    "matplotlib": {"report.plots"},
    "coal": {"world.geometry.convex_union"},
    "fcl": {"checking.geometry.solids"},
    "mujoco": {f"execution.mujoco.{module}" for module in ("bodies", "friction", "robot", "simulator")},
    "numba": {"compiled"},
    "ompl": {"world.motion.ompl"},
    "PIL": {
        "perception.dataset.frames", "perception.notes", "perception.overlay", "perception.rendering.software",
        "report.rendering.images",
    },
    "pinocchio": {
        "world.collision.broadphase", "world.robot.chain", "world.robot.hand", "world.robot.linkage",
        "world.robot.model",
    },
    "pybullet": {"execution.pybullet.client"},
    "pydantic": {
        "contest.service.web.described",
        "task.files.errors", "task.files.load", "task.files.robot.robot_file", "task.files.robot.robot_schema",
        "task.files.schema",
    },
    "rich": {"cli.progress", "cli.commands.results.compare", "results"},
    "rosbags": {"formats.trajectory"},
    "sapien": {"execution.sapien.client"},
    "shtab": {"cli.commands.installation.installed"},
    "scipy": {
        "checking.geometry.solids", "checking.physics.equilibrium", "perception.cameras.capture",
        "perception.cameras.noise", "perception.estimation.estimator", "perception.estimation.fusion",
        "perception.estimation.hypotheses", "perception.estimation.models.object_model",
        "perception.estimation.registration", "perception.estimation.assignment", "perception.grasps",
        "perception.estimation.models.occupancy", "perception.estimation.models.symmetry", "scoring.assignment",
        "streams.affordances.friction_cones", "task.mesh.parts", "task.mesh.support", "world.kinematics.seeds",
    },
    "sqlalchemy": {
        "contest.service.board", "contest.service.films", "contest.service.queue", "contest.service.store",
        "contest.service.submissions", "contest.service.teams", "contest.service.withdrawn", "contest.service.worker",
    },
    "threadpoolctl": {"threads"},
    "toppra": {"world.timing.path_rates"},
    "uvicorn": {"contest.service.web.prompt", "contest.service.serve"},
    "viser": {"report.viewer"},
    "trimesh": {"perception.rendering.surface", "task.mesh.mesh_file", "scenarios.make_objects"},
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


@cache
def _imports(path: Path) -> tuple[str, ...]:
    """Every module that a file imports, at its top or inside a function, for types or at run time."""
    return tuple(_imported(path))


def _imported(path: Path) -> Iterator[str]:
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
    if (
        room == "domains" and module.split(".")[-1] == "rules"
    ):  # a domain's own rules belong to the checker, and are as independent
        room = "checking"
    seen = {name.split(".")[1] for name in _imports(MODULES[module]) if name.startswith("tamp.")}
    assert seen - {room} <= ALLOWED[room], f"tamp.{module} must not import {sorted(seen - {room} - ALLOWED[room])}"


def _file_imports(module: str) -> set[str]:
    """The modules of the house that a module imports."""
    seen = {name.removeprefix("tamp.") for name in _imports(MODULES[module]) if name.startswith("tamp.")}
    return {name for name in seen if name in MODULES} - {module}


def test_no_circle_between_files() -> None:
    left = {module: _file_imports(module) for module in MODULES if MODULES[module].name != "__init__.py"}
    while left:
        free = {module for module, below in left.items() if not below & left.keys()}
        assert free, f"circle among {sorted(left)}"
        left = {module: below for module, below in left.items() if module not in free}


@pytest.mark.parametrize("module", MODULES)
def test_a_constant_has_one_value(module: str) -> None:
    """Where a module gives it another one further down, that is what all its functions see."""
    body = ast.parse(MODULES[module].read_text(encoding="utf-8")).body
    given = [target.id for node in body for target in _targets(node) if isinstance(target, ast.Name)]
    assert sorted(name for name in given if name != "_") == sorted({*given} - {"_"})


def _targets(node: ast.stmt) -> list[ast.expr]:
    if isinstance(node, ast.Assign):
        return [part for target in node.targets for part in getattr(target, "elts", [target])]
    return [node.target] if isinstance(node, ast.AnnAssign) and node.value is not None else []


@pytest.mark.parametrize("module", [name for name in MODULES if MODULES[name].name == "__init__.py" and name])
def test_every_room_says_what_it_is_for(module: str) -> None:
    assert ast.get_docstring(ast.parse(MODULES[module].read_text(encoding="utf-8")))


def test_the_rooms_have_an_order() -> None:
    """The rules themselves leave no way round in a circle."""
    left = {room: set(below) for room, below in ALLOWED.items()}
    while left:
        free = {room for room, below in left.items() if not below & left.keys()}
        assert free, f"circle among {sorted(left)}"
        left = {room: below for room, below in left.items() if room not in free}


# The rooms of the samplers, each of which may import those before it only; modules beside them have no room.
SAMPLERS = ("hand", "affordances", "motion", "grasping", "releasing", "pushing", "placing")


def test_the_rooms_of_the_samplers_are_known() -> None:
    assert {name.split(".")[1] for name in MODULES if name.count(".") == 2 and name.startswith("streams.")} == {
        *SAMPLERS
    }


@pytest.mark.parametrize("module", [name for name in MODULES if name.startswith("streams.")])
def test_samplers_import_one_way(module: str) -> None:
    room = module.split(".")[1]
    below = SAMPLERS[: SAMPLERS.index(room)] if room in SAMPLERS else ()
    seen = {name.split(".")[1] for name in _file_imports(module) if name.startswith("streams.")}
    assert seen & {*SAMPLERS} <= {room, *below}, f"tamp.{module} must not import {sorted(seen & {*SAMPLERS})}"


@pytest.mark.parametrize("library", HOMES)
def test_a_heavy_library_has_few_homes(library: str) -> None:
    homes = {name for name, path in MODULES.items() if any(i.partition(".")[0] == library for i in _imports(path))}
    assert homes <= HOMES[library]


def test_a_simulators_name_stands_in_its_own_folder_and_in_the_register() -> None:
    """Whoever asks for a simulator asks by name: another engine takes no edit elsewhere."""
    named = {
        name
        for name, path in MODULES.items()
        if re.search(r"pybullet(?!_data)", path.read_text(encoding="utf-8"), re.IGNORECASE)
    }
    assert {name for name in named if not name.startswith("execution.pybullet")} <= {"execution.simulators", "versions"}


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
