"""task.yaml -> Task."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from tamp.errors import ModelError, TaskError
from tamp.task.files import schema
from tamp.task.files.errors import sentence
from tamp.task.files.yaml_document import Document, FieldPath, read_document
from tamp.task.model import (
    At,
    Box,
    Capsule,
    Cylinder,
    Goal,
    In,
    Inertia,
    Limits,
    Mesh,
    Object,
    On,
    Region,
    Shape,
    Sphere,
    Symmetry,
    Table,
    Task,
)
from tamp.task.pose import Pose
from tamp.task.robots import is_path
from tamp.task.validate import validate

if TYPE_CHECKING:
    from _typeshed import StrPath


def load_task(path: StrPath, *, allow_outside: bool = False) -> Task:
    """Read a task.yaml.

    Args:
        path: the file.
        allow_outside: accept meshes and a robot outside the file's folder.

    Raises:
        TaskError: in one sentence with file, line, field and what would be valid.
    """
    path = Path(path)
    document = read_document(path)
    if not isinstance(document.value, Mapping):
        said = "empty" if document.value is None else "not a mapping"
        raise TaskError(f"{path}: the file is {said}; a task has the fields {', '.join(schema.TaskModel.model_fields)}")
    try:
        model = schema.TaskModel.model_validate(document.value)
    except ValidationError as error:
        raise TaskError(sentence(error, document)) from None
    reader = _Reader(document, path.resolve(), allow_outside)
    task = reader.task(model)
    validate(task, document)
    return task


class _Reader:
    """Turns the file's models into the task's nouns."""

    def __init__(self, document: Document, path: Path, allow_outside: bool) -> None:
        self._document = document
        self._path = path
        self._allow_outside = allow_outside

    def task(self, model: schema.TaskModel) -> Task:
        return Task(
            name=model.name or self._path.stem,
            objects=tuple(self._object(o, ("objects", i)) for i, o in enumerate(model.objects)),
            robot=self._robot(model.robot),
            base=None if model.base is None else _pose(model.base),
            home=model.home,
            regions=tuple(Region(r.name, r.box.center, r.box.size) for r in model.regions),
            table=Table(model.table.center, model.table.size, model.table.thickness),
            domain=model.domain,
            init=model.init,
            goal=model.goal,
            strategy=model.strategy,
            search=model.search,
            motion_planner=model.motion_planner,
            simulator=model.simulator,
            perceive=model.perceive,
            samplers=model.samplers,
            limits=Limits(model.limits.planning_s, model.limits.execution_sim_s),
            level=model.level,
            path=self._path,
        )

    def _robot(self, text: str) -> str:
        """The name as it is, or a path that leads to a file."""
        if is_path(text):
            self._file(text, ("robot",))
        return text

    def _object(self, model: schema.ObjectModel, field: FieldPath) -> Object:
        shape = self._shape(model.shape, (*field, "shape"))
        try:
            return self._made(model, shape)
        except ModelError as error:
            raise TaskError(f"{self._document.where(field)}: {error}") from None

    def _made(self, model: schema.ObjectModel, shape: Shape) -> Object:
        """The object of a shape; ModelError where no body has such a mass or such moments of inertia."""
        return Object(
            name=model.name,
            shape=shape,
            pose=_pose(model.pose),
            goal=None if model.goal is None else _goal(model.goal),
            mass=model.mass,
            friction=model.friction,
            symmetry=Symmetry(model.symmetry.x, model.symmetry.y, model.symmetry.z),
            category=model.category,
            inertia=None if model.inertia is None else Inertia(_pose(model.inertia.frame), model.inertia.moments),
        )

    def _shape(self, model: schema.ShapeModel, field: FieldPath) -> Shape:
        if model.box is not None:
            return Box(model.box)
        if model.cylinder is not None:
            return Cylinder(model.cylinder.radius, model.cylinder.height)
        if model.sphere is not None:
            return Sphere(model.sphere.radius)
        if model.capsule is not None:
            return Capsule(model.capsule.radius, model.capsule.height)
        assert model.mesh is not None
        path = self._file(model.mesh, (*field, "mesh"))
        return Mesh(path, 1.0 if model.scale is None else model.scale, bool(model.stand_in))

    def _file(self, text: str, field: FieldPath) -> Path:
        where, folder = self._document.where(field), self._path.parent
        try:
            path = (folder / text).resolve()
            is_file = path.is_file()
        except (OSError, RuntimeError, ValueError) as error:  # too long, a loop of links, a zero byte
            raise TaskError(f"{where}: {text[:40]!r} is no path: {str(error)[:60]}") from None
        if not self._allow_outside and not path.is_relative_to(folder):
            raise TaskError(f"{where}: {text} lies outside the task's folder; move it there or pass --allow-outside")
        if not is_file:
            raise TaskError(f"{where}: there is no file {text} in {self._document.name.rpartition('/')[0] or '.'}")
        return path


def _pose(model: schema.PoseModel) -> Pose:
    if model.rpy is not None:
        return Pose.from_rpy(model.xyz, model.rpy)
    return Pose(model.xyz, model.quat or (0.0, 0.0, 0.0, 1.0))


def _goal(model: schema.GoalModel) -> Goal:
    if model.pose is not None:
        return At(_pose(model.pose))
    if model.on is not None:
        return On(model.on)
    assert model.in_ is not None
    return In(model.in_)
