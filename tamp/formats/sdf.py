"""OCRTOC 2020: pairs of SDF 1.4 worlds. An object's name is its alias in the world; a mesh address names its model."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from tamp.errors import TaskError
from tamp.task.model import At, Mesh, Object, Table, Task
from tamp.task.pose import Pose

TABLE_2020 = Table(center=(0.0, 0.0), size=(0.8, 1.0))

Corners = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class _Body:
    """What a world says about one object."""

    model: str
    scale: float
    mass: float
    friction: float
    pose: Pose


def read_worlds(folder: Path, stand_ins: Path) -> tuple[tuple[Task, ...], tuple[str, ...]]:
    """All tasks below `folder`/tasks, and what could not be taken over.

    Meshes are looked for in `folder`/models_*/NAME and in `folder`/../2021/models/NAME. Where there is none, a box of
    the size in objects.csv is written below `stand_ins` and a warning says so.

    Raises:
        TaskError: where a world cannot be read, or neither mesh nor size of an object is known.
    """
    library = _Library(folder, stand_ins)
    worlds = sorted(folder.glob("tasks/*/input.world"))
    tasks = tuple(_task(path.parent.name, path, path.with_name("target.world"), library) for path in worlds)
    return tasks, tuple(library.warnings)


def _task(name: str, start: Path, target: Path, library: _Library) -> Task:
    starts, goals = _bodies(start), _bodies(target)
    unknown = sorted(goals.keys() - starts.keys())
    if unknown:
        raise TaskError(f"{target}: {', '.join(unknown)} not in {start}")
    objects = []
    for alias, body in starts.items():
        goal = At(goals[alias].pose) if alias in goals else None
        shape = Mesh(library.mesh(body.model, start), body.scale)
        objects.append(Object(alias, shape, body.pose, goal, body.mass, body.friction))
    return Task(name=name, objects=tuple(objects), table=TABLE_2020)


def _bodies(path: Path) -> dict[str, _Body]:
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except OSError as error:
        raise TaskError(f"{path}: cannot be read: {error.strerror}") from error
    except ElementTree.ParseError as error:
        raise TaskError(f"{path}: not XML: {error}") from error
    bodies: dict[str, _Body] = {}
    for model in root.iterfind("./world/model"):
        alias = model.get("name", "")
        try:
            bodies[alias] = _body(model)
        except ValueError as error:
            raise TaskError(f"{path}: model {alias!r}: {error}") from None
    return bodies


def _body(model: ElementTree.Element) -> _Body:
    address = _text(model, "link/collision/geometry/mesh/uri")
    scales = set(_numbers(model, "link/collision/geometry/mesh/scale", 3))
    if not address.startswith("model://"):
        raise ValueError(f"its mesh address is {address!r}; expected model://NAME/...")
    if len(scales) != 1:
        raise ValueError("its scale differs between axes")
    x, y, z, roll, pitch, yaw = _numbers(model, "pose", 6)
    return _Body(
        model=address.removeprefix("model://").partition("/")[0],
        scale=scales.pop(),
        mass=_numbers(model, "link/inertial/mass", 1)[0],
        friction=_numbers(model, "link/collision/surface/friction/ode/mu", 1)[0],
        pose=Pose.from_rpy((x, y, z), (roll, pitch, yaw)),
    )


def _text(model: ElementTree.Element, tag: str) -> str:
    text = model.findtext(tag)
    if text is None:
        raise ValueError(f"has no <{tag}>")
    return text.strip()


def _numbers(model: ElementTree.Element, tag: str, count: int) -> tuple[float, ...]:
    values = tuple(map(float, _text(model, tag).split()))
    if len(values) != count:
        raise ValueError(f"<{tag}> has {len(values)} numbers; expected {count}")
    return values


class _Library:
    """Finds a model's mesh, or makes a box stand in for it."""

    def __init__(self, folder: Path, stand_ins: Path) -> None:
        self._folders = [*sorted(folder.glob("models_*")), folder.parent / "2021" / "models"]
        self._sizes = _sizes(f / "objects.csv" for f in self._folders)
        self._stand_ins = stand_ins
        self.warnings: list[str] = []

    def mesh(self, model: str, needed_by: Path) -> Path:
        for folder in self._folders:
            path = folder / model / "collision.obj"
            if path.is_file():
                return path
        if model not in self._sizes:
            raise TaskError(f"{needed_by}: neither a mesh nor a size is known of the model {model!r}")
        path = self._stand_ins / model / "stand_in.obj"
        warning = f"{model}: no mesh; a box of its size stands in for it"
        if warning not in self.warnings:
            self.warnings.append(warning)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(_box_obj(model, self._sizes[model]), encoding="utf-8")
        return path


def _sizes(files: Iterable[Path]) -> Mapping[str, Corners]:
    """Model -> lower and upper corner [m]."""
    sizes: dict[str, Corners] = {}
    for path in files:
        if not path.is_file():
            continue
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                x, y, z = ((float(row[f"min_{a}"]), float(row[f"max_{a}"])) for a in "xyz")
                sizes.setdefault(row["object"], ((x[0], y[0], z[0]), (x[1], y[1], z[1])))
    return sizes


def _box_obj(name: str, corners: Corners) -> str:
    (x0, y0, z0), (x1, y1, z1) = corners
    vertices = [(x, y, z) for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    faces = ((1, 4, 3, 2), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8))
    lines = [f"o {name}", *(f"v {x!r} {y!r} {z!r}" for x, y, z in vertices)]
    return "\n".join([*lines, *(f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in faces)]) + "\n"
