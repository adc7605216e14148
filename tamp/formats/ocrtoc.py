"""OCRTOC's own task files -> task.yaml files with their meshes beside them.

2021 and 2022: `scenes/ID.yaml` and `targets/ID.yaml`, meshes and models.yaml in `models/`.
2020: `tasks/L-N/input.world` and `target.world` in SDF 1.4, meshes and objects.csv in `models*/`.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from tamp.errors import TaskError
from tamp.formats.models import model_name
from tamp.formats.pairs import read_pairs
from tamp.formats.worlds import BASE_2020, HOME_2020, ROBOT_2020, read_worlds
from tamp.task.files.save import save_task
from tamp.task.model import Mesh, Shape, Task


@dataclass(frozen=True)
class Imported:
    """What an import wrote.

    Attributes:
        paths: the task files.
        warnings: one sentence for each thing that could not be taken over as it is.
    """

    paths: tuple[Path, ...]
    warnings: tuple[str, ...] = ()


def import_ocrtoc(folder: Path, out: Path, *, own_robot: bool = False) -> Imported:
    """Write a task.yaml for each task in `folder`, and the meshes they need into `out`/models.

    Coloured meshes, visual/MODEL.ply, are taken along as visual.ply beside the others.

    Args:
        folder: holds tasks of one year.
        out: a folder for the tasks; made where it is not there.
        own_robot: give tasks of 2020 that year's robot, where it stood; else all have the default one.

    Raises:
        TaskError: where the folder holds no tasks of OCRTOC, or one of them cannot be read.
    """
    tasks, warnings = _read(folder, out / "models", own_robot)
    out.mkdir(parents=True, exist_ok=True)
    looks = folder / "visual"
    paths = []
    for task in tasks:
        paths.append(out / f"{task.name}.yaml")
        save_task(_with_meshes_in(task, out / "models", looks), paths[-1])
    return Imported(tuple(paths), warnings)


def _read(folder: Path, stand_ins: Path, own_robot: bool) -> tuple[tuple[Task, ...], tuple[str, ...]]:
    if (folder / "scenes").is_dir() and (folder / "targets").is_dir():
        return read_pairs(folder), ()
    if any(folder.glob("tasks/*/input.world")):
        tasks, warnings = read_worlds(folder, stand_ins)
        if own_robot:
            tasks = tuple(replace(task, robot=ROBOT_2020, base=BASE_2020, home=HOME_2020) for task in tasks)
        return tasks, warnings
    raise TaskError(
        f"{folder}: holds no tasks of OCRTOC; expected scenes/ and targets/ (2021) or tasks/*/input.world (2020)"
    )


def _with_meshes_in(task: Task, folder: Path, looks: Path) -> Task:
    """The same task on copies of its meshes in `folder`, with the coloured ones beside them where `looks` has some."""
    return replace(task, objects=tuple(replace(o, shape=_copied(o.shape, folder, looks)) for o in task.objects))


def _copied(shape: Shape, folder: Path, looks: Path) -> Shape:
    if not isinstance(shape, Mesh):
        return shape
    copy = folder / model_name(shape) / shape.path.name
    if copy.resolve() != shape.path.resolve():
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(shape.path, copy)
    look = looks / f"{model_name(shape)}.ply"
    if look.is_file():
        shutil.copyfile(look, copy.with_name("visual.ply"))
    return replace(shape, path=copy)
