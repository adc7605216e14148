"""OCRTOC's own task files -> task.yaml files with their meshes beside them.

2021: `scenes/ID.yaml` and `targets/ID.yaml`, `model: list of [x, y, z, roll, pitch, yaw]`, meshes in `models/NAME/`.
2020: `tasks/L-N/input.world` and `target.world` in SDF 1.4, meshes in `models_*/NAME/`, sizes in `objects.csv`.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tamp.errors import TaskError
from tamp.formats.sdf import read_worlds
from tamp.task.document import Document, FieldPath, read_document
from tamp.task.model import At, Mesh, Object, Task
from tamp.task.pose import Pose
from tamp.task.save import save_task

MASS_2021 = 0.1
FRICTION_2021 = 0.5


@dataclass(frozen=True)
class Imported:
    """What an import wrote.

    Attributes:
        paths: the task files.
        warnings: one sentence for each thing that could not be taken over as it is.
    """

    paths: tuple[Path, ...]
    warnings: tuple[str, ...] = ()


def import_ocrtoc(folder: Path, out: Path) -> Imported:
    """Write a task.yaml for each task in `folder`, and the meshes they need into `out`/models.

    Raises:
        TaskError: where the folder holds no tasks of OCRTOC, or one of them cannot be read.
    """
    warnings: tuple[str, ...]
    if (folder / "scenes").is_dir() and (folder / "targets").is_dir():
        tasks, warnings = _read_pairs(folder), ()
    elif any(folder.glob("tasks/*/input.world")):
        tasks, warnings = read_worlds(folder, out / "models")
    else:
        raise TaskError(
            f"{folder}: holds no tasks of OCRTOC; expected scenes/ and targets/ (2021) or tasks/*/input.world (2020)"
        )
    out.mkdir(parents=True, exist_ok=True)
    paths = []
    for task in tasks:
        paths.append(out / f"{task.name}.yaml")
        save_task(_with_meshes_in(task, out / "models"), paths[-1])
    return Imported(tuple(paths), warnings)


def _read_pairs(folder: Path) -> tuple[Task, ...]:
    scenes = sorted((folder / "scenes").glob("*.yaml"))
    if not scenes:
        raise TaskError(f"{folder / 'scenes'}: holds no *.yaml")
    return tuple(read_pair(scene, folder / "targets" / scene.name, folder / "models") for scene in scenes)


def read_pair(scene: Path, target: Path, models: Path) -> Task:
    """One task of 2021. Instances of a model are called `model`, `model_2`, ... and matched with goals in order.

    Args:
        scene: start poses.
        target: goal poses.
        models: folder of NAME/collision.obj.

    Raises:
        TaskError: where a file is not of the form, a mesh is missing, or the two files list different objects.
    """
    starts, goals = _instances(read_document(scene)), _instances(read_document(target))
    unmatched = sorted(starts.keys() ^ goals.keys())
    if unmatched:
        raise TaskError(f"{target}: lists other objects than {scene}: {', '.join(unmatched)} stand in one of them only")
    objects = []
    for name, (model, pose) in starts.items():
        mesh = models / model / "collision.obj"
        if not mesh.is_file():
            raise TaskError(f"{scene}: {model}: there is no mesh {mesh}")
        objects.append(Object(name, Mesh(mesh), pose, At(goals[name][1]), MASS_2021, FRICTION_2021))
    return Task(name=scene.stem, objects=tuple(objects))


def _instances(document: Document) -> dict[str, tuple[str, Pose]]:
    """Instance name -> (model, pose), in the file's order."""
    if not isinstance(document.value, dict):
        raise TaskError(f"{document.name}: expected a mapping of model names to lists of poses")
    taken = set(document.value)
    found: dict[str, tuple[str, Pose]] = {}
    for model, rows in document.value.items():
        if not isinstance(rows, tuple):
            raise TaskError(f"{document.where((model,))}: expected a list of [x, y, z, roll, pitch, yaw]")
        for index, row in enumerate(rows):
            name = model if index == 0 else _instance_name(model, index + 1, taken)
            found[name] = (model, _pose(row, document, (model, index)))
    return found


def _instance_name(model: str, number: int, taken: set[str]) -> str:
    """`model_2` for the second instance, unless a model is called so: then `model_2_instance`."""
    name = f"{model}_{number}"
    return f"{name}_instance" if name in taken else name


def _pose(row: Any, document: Document, field: FieldPath) -> Pose:
    if not isinstance(row, tuple) or len(row) != 6 or not all(type(v) in (int, float) for v in row):
        raise TaskError(f"{document.where(field)}: expected [x, y, z, roll, pitch, yaw]")
    try:
        return Pose.from_rpy(row[:3], row[3:])
    except ValueError as error:
        raise TaskError(f"{document.where(field)}: {error}") from None


def _with_meshes_in(task: Task, folder: Path) -> Task:
    """The same task on copies of its meshes in `folder`."""
    return replace(task, objects=tuple(replace(o, shape=_copied(o.shape, folder)) for o in task.objects))


def _copied(shape: Any, folder: Path) -> Any:
    if not isinstance(shape, Mesh):
        return shape
    copy = folder / shape.path.parent.name / shape.path.name
    if copy.resolve() != shape.path.resolve():
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(shape.path, copy)
    return replace(shape, path=copy)
