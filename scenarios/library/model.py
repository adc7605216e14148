"""A library of objects: a folder with `objects.yaml` and the meshes it refers to.

    objects:
      - {name: cup_1, category: cup, set: trial, mesh: cup_1.obj, mass: 0.09, friction: 0.5, symmetry: {z: 360},
         hollow: [0.03, 0.03], made: {kind: cup, radius: 0.036, height: 0.08}}

Metres and kilograms. A mesh's origin is the centre of its bounding box, z up as the object is used. `symmetry` says in
how many turns about x, y, z it looks the same: 1 none (and what is left out), 360 any, as in task.yaml. `top` and
`hollow` are the sides of the flat area that others can stand on and of the opening that others can be put into, both
about the mesh's z axis; absent where there is none. `made` says how the object was made; a reader takes only its kind.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tamp.errors import TaskError
from tamp.scenarios.library.kinds import CATEGORIES, Area
from tamp.task import Mesh
from tamp.task.files.yaml_document import Document, FieldPath, read_document
from tamp.task.model import ANY_TURN, Symmetry

FILE = "objects.yaml"
SETS = ("trial", "contest")
FOLDER = Path(__file__).resolve().parent / "objects"
"""Where our own library lies."""

_REQUIRED = ("name", "category", "set", "mesh", "mass", "friction", "symmetry")
_OPTIONAL = ("top", "hollow", "made")


@dataclass(frozen=True)
class Model:
    """One object of a library.

    Attributes:
        name: unique in its library.
        category: one of the paper's twelve.
        set: "trial" for objects known beforehand, "contest" for those kept back.
        shape: its mesh.
        mass: [kg].
        friction: coefficient of lateral friction.
        symmetry: how it may turn and look the same.
        top: sides of the flat area that carries others [m], or None.
        hollow: sides of the opening that takes others in [m], or None.
        kind: what `made` calls its kind; its category where the file does not say.
    """

    name: str
    category: str
    set: str
    shape: Mesh
    mass: float
    friction: float
    symmetry: Symmetry
    top: Area | None
    hollow: Area | None
    kind: str


def read_library(folder: Path = FOLDER) -> tuple[Model, ...]:
    """Read a library's objects in the order of its file.

    Raises:
        TaskError: in one sentence with file, line, field and what would be valid.
    """
    document = read_document(folder / FILE)
    entries = document.value.get("objects") if isinstance(document.value, Mapping) else None
    if not isinstance(entries, tuple) or not entries:
        raise TaskError(f"{document.name}: a library has the field objects, a list of at least one object")
    models = tuple(_Entry(document, ("objects", i), entry, folder).model() for i, entry in enumerate(entries))
    for i, model in enumerate(models):
        if any(model.name == other.name for other in models[:i]):
            where = document.where(("objects", i, "name"))
            raise TaskError(f"{where}: {model.name!r} is taken; names of a library differ")
    return models


class _Entry:
    """One object of the file; every question it is asked it answers or refuses in one sentence."""

    def __init__(self, document: Document, field: FieldPath, value: Any, folder: Path) -> None:
        self._document, self._field, self._folder = document, field, folder
        if not isinstance(value, Mapping):
            raise self._refusal((), f"must be a mapping with the fields {', '.join(_REQUIRED)}")
        self._value: Mapping[str, Any] = value

    def model(self) -> Model:
        for key in self._value:
            if key not in (*_REQUIRED, *_OPTIONAL):
                raise self._refusal((key,), f"unknown field; valid here are {', '.join((*_REQUIRED, *_OPTIONAL))}")
        made = self._value.get("made")
        category = self._word("category", CATEGORIES)
        return Model(
            name=self._word("name"),
            category=category,
            set=self._word("set", SETS),
            shape=self._mesh(),
            mass=self._number("mass"),
            friction=self._number("friction"),
            symmetry=self._symmetry(),
            top=self._area("top"),
            hollow=self._area("hollow"),
            kind=str(made.get("kind", category)) if isinstance(made, Mapping) else category,
        )

    def _word(self, key: str, valid: tuple[str, ...] = ()) -> str:
        value = self._get(key)
        if not isinstance(value, str) or (valid and value not in valid):
            raise self._refusal((key,), f"{value!r} must be {'one of ' + ', '.join(valid) if valid else 'text'}")
        return value

    def _number(self, key: str) -> float:
        value = self._get(key)
        if not _positive(value):
            raise self._refusal((key,), f"{value!r} must be a number over 0")
        return float(value)

    def _symmetry(self) -> Symmetry:
        value = self._get("symmetry")
        if not isinstance(value, Mapping) or not all(
            axis in "xyz" and type(fold) is int and 1 <= fold <= ANY_TURN for axis, fold in value.items()
        ):
            raise self._refusal(("symmetry",), f"must be a mapping of x, y, z to whole numbers from 1 to {ANY_TURN}")
        return Symmetry(**value)

    def _area(self, key: str) -> Area | None:
        value = self._value.get(key)
        if value is None:
            return None
        if not isinstance(value, tuple) or len(value) != 2 or not all(map(_positive, value)):
            raise self._refusal((key,), "must be two lengths over 0, along x and y")
        return float(value[0]), float(value[1])

    def _mesh(self) -> Mesh:
        text = self._word("mesh")
        path = (self._folder / text).resolve()
        if not path.is_relative_to(self._folder.resolve()) or not path.is_file():
            raise self._refusal(("mesh",), f"there is no file {text} in the library's folder")
        return Mesh(path)

    def _get(self, key: str) -> Any:
        if key not in self._value:
            raise self._refusal((), f"{key} is missing; an object has {', '.join(_REQUIRED)}")
        return self._value[key]

    def _refusal(self, key: FieldPath, complaint: str) -> TaskError:
        return TaskError(f"{self._document.where((*self._field, *key))}: {complaint}")


def _positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < float("inf")
