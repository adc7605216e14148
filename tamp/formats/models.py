"""OCRTOC's folders of object models: meshes, sizes, classes and symmetries by name.

2021: `NAME/collision.obj` and models.yaml. 2020: the same or `NAME/collision_meshes/collision.obj`, and objects.csv.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from tamp.errors import TaskError
from tamp.formats.obj import box_obj
from tamp.task.model import ANY_TURN, Mesh, Symmetry

COLLISION, STAND_IN = "collision.obj", "stand_in.obj"
INNER = "collision_meshes"
"""The folder in a model's folder that holds its mesh in OCRTOC 2020's own layout."""

ROW = ("object", "class", "source", "location", "metric", "min_x", "max_x", "min_y", "max_y", "min_z", "max_z",
       "width", "length", "height")  # fmt: skip
"""The columns of objects.csv; lengths in metres."""

_TURNS = {"": ANY_TURN, "90": 4, "180": 2}
"""What may stand behind an axis in `symmetric_z180`, and the fold that it means."""

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")

_FOLDS = (*range(1, 13), ANY_TURN)


@dataclass(frozen=True)
class Model:
    """What objects.csv says of a model.

    Attributes:
        category: its class.
        symmetry: from its metric.
        lower, upper: corners of its bounding box [m].
    """

    category: str
    symmetry: Symmetry
    lower: tuple[float, ...]
    upper: tuple[float, ...]


class Library:
    """Finds a model's mesh, or makes a box stand in for it.

    Attributes:
        warnings: one sentence a model without a mesh.
    """

    def __init__(self, folder: Path, stand_ins: Path) -> None:
        self._folders = [*sorted(folder.glob("models*")), folder.parent / "2021" / "models"]
        self._models = _read_objects(f / "objects.csv" for f in self._folders)
        self._stand_ins = stand_ins
        self.warnings: list[str] = []

    def model(self, name: str) -> Model | None:
        """What is known of a model."""
        return self._models.get(name)

    def mesh(self, name: str, needed_by: Path, scale: float = 1.0) -> Mesh:
        """A model's mesh at a scale.

        Raises:
            TaskError: where neither a mesh nor a size is known.
        """
        for folder in self._folders:
            for path in (folder / name / COLLISION, folder / name / INNER / COLLISION):
                if path.is_file():
                    return Mesh(path, scale)
        model = self._models.get(name)
        if model is None:
            raise TaskError(f"{needed_by}: neither a mesh nor a size is known of the model {name!r}")
        path = self._stand_ins / name / STAND_IN
        warning = f"{name}: no mesh; a box of its size stands in for it"
        if warning not in self.warnings:
            self.warnings.append(warning)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(box_obj(name, model.lower, model.upper), encoding="utf-8")
        return Mesh(path, scale, stand_in=True)


def model_name(mesh: Mesh) -> str:
    """What the model is called whose mesh this is: its folder in OCRTOC's layouts, else its file."""
    if mesh.path.name not in (COLLISION, STAND_IN):
        return mesh.path.stem
    folder = mesh.path.parent
    return folder.parent.name if folder.name == INNER else folder.name


def check_name(name: str) -> str:
    """The name of a model or an object, if it can be one in a task and in a path.

    Raises:
        ValueError: where it cannot.
    """
    if _NAME.fullmatch(name) is None:
        raise ValueError(f"the name {name!r} is not of letters, digits, _, . and -, at most 64")
    return name


def read_symmetries(path: Path) -> dict[str, Symmetry]:
    """Model -> symmetry from a models.yaml; empty where there is none.

    Raises:
        TaskError: where it is not a mapping of names to folds about x, y and z.
    """
    if not path.is_file():
        return {}
    try:
        # Not as strictly as a task: OCRTOC's own file has a model twice, and its programs take the last.
        models = yaml.safe_load(path.read_bytes())
    except yaml.YAMLError as error:
        raise TaskError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(models, dict):
        raise TaskError(f"{path}: expected a mapping of model names to {{x: 1, y: 1, z: 1}}")
    for name, folds in models.items():
        if not isinstance(folds, dict) or set(folds) != {"x", "y", "z"} or any(n not in _FOLDS for n in folds.values()):
            raise TaskError(f"{path}: {name}: expected x, y and z, each a number 1 to 12, or 360")
    return {str(name): Symmetry(**folds) for name, folds in models.items()}


def metric_name(symmetry: Symmetry) -> str | None:
    """What objects.csv calls a symmetry; None where it has no word for it."""
    turned = [(axis, fold) for axis in "xyz" if (fold := getattr(symmetry, axis)) != 1]
    if not turned:
        return "asymmetric"
    words = {fold: word for word, fold in _TURNS.items()}
    (axis, fold), *others = turned
    return None if others or fold not in words else f"symmetric_{axis}{words[fold]}"


def _read_objects(files: Iterable[Path]) -> Mapping[str, Model]:
    """Name -> model; the first file that has it counts."""
    models: dict[str, Model] = {}
    for path in files:
        if not path.is_file():
            continue
        for number, row in enumerate(_rows(path), start=2):
            model = _model(row, f"{path}:{number}")
            models.setdefault(row["object"], model)
    return models


def _rows(path: Path) -> list[dict[str, str]]:
    try:
        return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TaskError(f"{path}: not a table of comma-separated values: {error}") from error


def _model(row: Mapping[str, str], where: str) -> Model:
    try:
        lower, upper = (tuple(float(row[f"{end}_{axis}"]) for axis in "xyz") for end in ("min", "max"))
        return Model(row["class"], _symmetry(row["metric"]), lower, upper)
    except (KeyError, TypeError, ValueError) as error:
        raise TaskError(f"{where}: not a row with the columns {', '.join(ROW)}: {error}") from None


def _symmetry(metric: str) -> Symmetry:
    if metric == "asymmetric":
        return Symmetry()
    word, _, mark = metric.partition("_")
    if word != "symmetric" or mark[:1] not in ("x", "y", "z") or mark[1:] not in _TURNS:
        raise ValueError(f"the metric {metric!r} is unknown")
    return Symmetry(**{mark[0]: _TURNS[mark[1:]]})
