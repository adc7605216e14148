"""OCRTOC 2021 and 2022: pairs of YAML files, `model: list of [x, y, z, roll, pitch, yaw]`, one entry an instance.

Instances of a model are called `model`, `model_2`, ... and matched with goals in order.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from tamp.errors import TaskError
from tamp.formats.angles import roll_pitch_yaw
from tamp.formats.models import COLLISION, check_name, model_name, read_symmetries
from tamp.task.files.yaml_document import Document, FieldPath, read_document
from tamp.task.model import At, Mesh, Object, Symmetry, Task
from tamp.task.pose import Pose

MASS_2021 = 0.1
FRICTION_2021 = 0.5


def read_pairs(folder: Path) -> tuple[Task, ...]:
    """All tasks of `folder`/scenes and targets.

    Raises:
        TaskError: where there is none, or one cannot be read.
    """
    scenes = sorted((folder / "scenes").glob("*.yaml"))
    if not scenes:
        raise TaskError(f"{folder / 'scenes'}: holds no *.yaml")
    models = folder / "models"
    symmetries = read_symmetries(models / "models.yaml")
    return tuple(read_pair(scene, folder / "targets" / scene.name, models, symmetries) for scene in scenes)


def read_pair(scene: Path, target: Path, models: Path, symmetries: Mapping[str, Symmetry]) -> Task:
    """One task.

    Args:
        scene: start poses.
        target: goal poses.
        models: folder of NAME/collision.obj.
        symmetries: of the models that have any.

    Raises:
        TaskError: where a file is not of the form, a mesh is missing, or the two files list different objects.
    """
    starts, goals = _instances(read_document(scene)), _instances(read_document(target))
    unmatched = sorted(starts.keys() ^ goals.keys())
    if unmatched:
        raise TaskError(f"{target}: lists other objects than {scene}: {', '.join(unmatched)} stand in one of them only")
    objects = []
    for name, (model, pose) in starts.items():
        mesh = models / model / COLLISION
        if not mesh.is_file():
            raise TaskError(f"{scene}: {model}: there is no mesh {mesh}")
        goal = At(goals[name][1])
        symmetry = symmetries.get(model, Symmetry())
        objects.append(Object(name, Mesh(mesh), pose, goal, MASS_2021, FRICTION_2021, symmetry))
    return Task(name=scene.stem, objects=tuple(objects))


def write_pair(task: Task, models: Mapping[str, str], folder: Path) -> Path:
    """Write `folder`/scenes and targets/NAME.yaml, and return the first.

    Args:
        task: its goals are poses.
        models: object -> model, as `instance_models` gives them.
        folder: made where absent.
    """
    starts: dict[str, list[list[float]]] = {}
    goals: dict[str, list[list[float]]] = {}
    for o in task.objects:
        assert isinstance(o.goal, At)
        for rows, pose in ((starts, o.pose), (goals, o.goal.pose)):
            rows.setdefault(models[o.name], []).append([*pose.xyz, *roll_pitch_yaw(pose)])
    for name, rows in (("scenes", starts), ("targets", goals)):
        path = folder / name / f"{task.name}.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        text = yaml.safe_dump(rows, sort_keys=False, default_flow_style=None, width=1000, allow_unicode=True)
        path.write_text(text, encoding="utf-8")
    return folder / "scenes" / f"{task.name}.yaml"


def instance_models(objects: Sequence[Object]) -> dict[str, str] | None:
    """Object -> the model it is an instance of, if reading the models' names would give these names in this order.

    None where it would not, as where a mesh has several scales or an instance's name is of one's own choosing.
    """
    shapes: dict[str, Any] = {}
    models = {o.name: model_name(o.shape) if isinstance(o.shape, Mesh) else o.name for o in objects}
    if any(shapes.setdefault(models[o.name], o.shape) != o.shape for o in objects):
        return None
    counts = {model: sum(m == model for m in models.values()) for model in models.values()}
    return models if list(_names(counts)) == list(models) else None


def _names(counts: Mapping[str, int]) -> Iterable[str]:
    """How instances are called, from how many each model has: `model_2` is the second.

    Where a model itself is called so, it is `model_2_instance`.
    """
    for model, count in counts.items():
        yield model
        for number in range(2, count + 1):
            name = f"{model}_{number}"
            yield f"{name}_instance" if name in counts else name


def _instances(document: Document) -> dict[str, tuple[str, Pose]]:
    """Instance name -> (model, pose), in the file's order."""
    if not isinstance(document.value, dict):
        raise TaskError(f"{document.name}: expected a mapping of model names to lists of poses")
    found: list[tuple[str, Pose]] = []
    for model, rows in document.value.items():
        try:
            check_name(model)
        except ValueError as error:
            raise TaskError(f"{document.where((model,))}: {error}") from None
        if not isinstance(rows, tuple):
            raise TaskError(f"{document.where((model,))}: expected a list of [x, y, z, roll, pitch, yaw]")
        found += [(model, _pose(row, document, (model, index))) for index, row in enumerate(rows)]
    counts = {model: len(rows) for model, rows in document.value.items() if rows}
    return dict(zip(_names(counts), found, strict=True))


def _pose(row: Any, document: Document, field: FieldPath) -> Pose:
    if not isinstance(row, tuple) or len(row) != 6 or not all(type(v) in (int, float) for v in row):
        raise TaskError(f"{document.where(field)}: expected [x, y, z, roll, pitch, yaw]")
    try:
        return Pose.from_rpy(row[:3], row[3:])
    except ValueError as error:
        raise TaskError(f"{document.where(field)}: {error}") from None
