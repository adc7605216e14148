"""Pictures of tasks, and the public tasks as files."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tamp.contest.service.contest import Kind
from tamp.contest.service.scratch import unfinished
from tamp.formats.obj import shape_obj
from tamp.perception.rendering.scene import surfaces
from tamp.perception.rendering.surface import write_ply
from tamp.report.rendering.scene import render_task
from tamp.task import Mesh, Task
from tamp.task.files.digest import task_sha256
from tamp.task.files.save import save_task


def picture(task: Task, data: Path, kind: Kind) -> Path:
    """A picture of a task's start with its goals as ghosts, in the service's folder; drawn once."""
    place = data / "pictures" / kind / f"{task_sha256(task)[:16]}.png"
    if not place.exists():
        with unfinished(data, place) as part:
            render_task(task, {item.name: item.pose for item in task.objects}, part, goals=True)
    return place


def task_archive(tasks: Sequence[Task], archive: zipfile.ZipFile) -> None:
    """Write tasks with the meshes that they need, each in a folder of its own, into an archive."""
    for task in tasks:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            looks = surfaces(task)
            objects = []
            for number, item in enumerate(task.objects):
                if isinstance(item.shape, Mesh):
                    place = folder / f"{number:03}"
                    place.mkdir()
                    (place / "collision.obj").write_bytes(shape_obj(item.shape))
                    if looks[item.name].colored:
                        write_ply(looks[item.name], place / "visual.ply")
                    objects.append(replace(item, shape=Mesh(place / "collision.obj")))
                else:
                    objects.append(item)
            save_task(replace(task, objects=tuple(objects)), folder / "task.yaml")
            for file in sorted(folder.rglob("*")):
                if file.is_file():
                    archive.write(file, f"{task.name}/{file.relative_to(folder).as_posix()}")
