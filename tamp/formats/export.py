"""Tasks -> OCRTOC's own task files, with the models they need, and what those files have no place for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Literal

import yaml

from tamp.errors import TaskError
from tamp.formats.models import COLLISION, INNER, STAND_IN, metric_name, model_name
from tamp.formats.obj import shape_obj
from tamp.formats.pairs import FRICTION_2021, MASS_2021, instance_models, write_pair
from tamp.formats.worlds import TABLE_2020, level_of
from tamp.formats.write_worlds import objects_csv, write_worlds
from tamp.task.model import In, Limits, Mesh, Object, On, Shape, Table, Task
from tamp.task.robot import DEFAULT_ROBOT

Year = Literal[2020, 2021]


@dataclass(frozen=True)
class Exported:
    """What an export wrote.

    Attributes:
        paths: each task's start scene.
        warnings: one sentence for each thing that the form has no place for.
    """

    paths: tuple[Path, ...]
    warnings: tuple[str, ...] = ()


def export_ocrtoc(tasks: Sequence[Task], out: Path, year: Year) -> Exported:
    """Write tasks as OCRTOC's own files; `tamp import ocrtoc` reads them back.

    2021: `scenes/NAME.yaml`, `targets/NAME.yaml`, `models/MODEL/collision.obj` and models.yaml.
    2020: `tasks/NAME/input.world` and `target.world`, `models/MODEL/collision_meshes/collision.obj`, objects.csv.

    Raises:
        TaskError: where a goal is no pose, where an object has none (2021), where a mesh cannot be read, or where two
            models of one name differ.
    """
    shelf = _Shelf(out / "models", year)
    paths, warnings = [], []
    for task in tasks:
        _require_poses(task, year)
        models = _models_2020(task) if year == 2020 else instance_models(task.objects)
        if models is None:
            warnings.append(f"task {task.name}: each object becomes a model of its own, so that it keeps its name")
            models = {o.name: o.name for o in task.objects}
        for o in task.objects:
            shelf.add(models[o.name], o)
        warnings += [f"task {task.name}: {lost}" for lost in _lost(task, year)]
        paths.append((write_worlds if year == 2020 else write_pair)(task, models, out))
    shelf.close()
    return Exported(tuple(paths), tuple(warnings))


def _require_poses(task: Task, year: Year) -> None:
    for o in task.objects:
        if isinstance(o.goal, On | In):
            raise TaskError(f"task {task.name}: the goal of {o.name} is no pose, and OCRTOC's files know only poses")
        if o.goal is None and year == 2021:
            raise TaskError(f"task {task.name}: {o.name} has no goal; in OCRTOC's files of 2021 every object has one")


def _models_2020(task: Task) -> dict[str, str]:
    return {o.name: model_name(o.shape) if isinstance(o.shape, Mesh) else o.name for o in task.objects}


def _lost(task: Task, year: Year) -> Iterator[str]:
    """What the form has no place for, in words."""
    own = {"robot": DEFAULT_ROBOT, "table": TABLE_2020 if year == 2020 else Table(), "regions": (), "limits": Limits()}
    own |= {"level": level_of(task.name) if year == 2020 else None}
    lost = [name for name, value in own.items() if getattr(task, name) != value]
    lost += ["samplers"] if task.samplers else []
    if year == 2021:
        usual = Object("", Mesh(Path()), task.objects[0].pose, mass=MASS_2021, friction=FRICTION_2021)
        fields = ("mass", "friction", "category", "inertia")
        lost += [name for name in fields if any(getattr(o, name) != getattr(usual, name) for o in task.objects)]
    elif any(metric_name(o.symmetry) is None for o in task.objects):
        lost.append("symmetry about several axes")
    if any(not isinstance(o.shape, Mesh) for o in task.objects):
        lost.append("the exact form of what is no mesh")
    if year == 2021 and any(isinstance(o.shape, Mesh) and o.shape.scale != 1.0 for o in task.objects):
        lost.append("scales, which are worked into the meshes")
    if lost:
        yield f"the files of {year} have no place for {', '.join(lost)}"


class _Shelf:
    """The models of all tasks: each written once, under one name."""

    def __init__(self, folder: Path, year: Year) -> None:
        self._folder = folder
        self._year = year
        self._texts: dict[Shape, bytes] = {}
        self._models: dict[str, Object] = {}

    def add(self, name: str, o: Object) -> None:
        """Write the object's shape as the model `name`, unless it stands there already."""
        shape = replace(o.shape, scale=1.0) if self._year == 2020 and isinstance(o.shape, Mesh) else o.shape
        first = self._models.setdefault(name, o)
        text = self._texts[shape] if shape in self._texts else self._texts.setdefault(shape, shape_obj(shape))
        path = self._path(name, shape.path.name if isinstance(shape, Mesh) else COLLISION)
        if first is o:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)
        elif path.read_bytes() != text or (first.symmetry, first.category) != (o.symmetry, o.category):
            raise TaskError(f"two models called {name} differ; export their tasks into folders of their own")

    def _path(self, name: str, file: str) -> Path:
        if self._year == 2021:
            return self._folder / name / COLLISION
        return self._folder / name / STAND_IN if file == STAND_IN else self._folder / name / INNER / COLLISION

    def close(self) -> None:
        """Write what is told of the models in one file."""
        if self._year == 2020:
            (self._folder / "objects.csv").write_text(objects_csv(self._models), encoding="utf-8")
            return
        folds = {name: asdict(o.symmetry) for name, o in self._models.items()}
        (self._folder / "models.yaml").write_text(yaml.safe_dump(folds, sort_keys=False), encoding="utf-8")
