"""Many views of many scenes, rendered with a sensor's noise and labelled; resumable."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Intrinsics, Noise, StereoNoise, looking_at
from tamp.perception.cameras.noise import measured
from tamp.perception.dataset.frames import Label, LabelledFrame, steps
from tamp.perception.dataset.layouts import layout as layout_of
from tamp.perception.dataset.scenes import random_scene
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.scene import Body, objects_at, table_body
from tamp.perception.rendering.surface import Surface, model_name, surface_of
from tamp.task.model import Object, Table, Task
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

VIEWS = 79
"""Views of a scene in OCRTOC's data set."""

SENSOR = Intrinsics.from_field_of_view(1280, 720, math.radians(43.6))


def around(table: Table, count: int, rng: np.random.Generator) -> Iterator[Array]:
    """Camera poses (4, 4) spread over the upper part of a sphere around the table's middle, looking at it.

    A spiral by the golden angle between 20 and 80 degrees of elevation, 0.55 to 0.95 m away.
    """
    golden = math.pi * (3 - math.sqrt(5))
    low, high = math.sin(math.radians(20)), math.sin(math.radians(80))
    for index in range(count):
        height = low + (high - low) * (index + 0.5) / count
        flat, angle = math.sqrt(1 - height**2), golden * index
        eye = np.array([flat * math.cos(angle), flat * math.sin(angle), height]) * rng.uniform(0.55, 0.95)
        target = np.append(rng.uniform(-0.06, 0.06, 2), 0.04)
        middle = np.array([*table.center, 0.0])
        yield looking_at(middle + eye, middle + target)


def write_dataset(
    scenes: Sequence[Mapping[str, Pose]],
    objects: Mapping[str, Surface],
    folder: Path,
    *,
    views: int = VIEWS,
    intrinsics: Intrinsics = SENSOR,
    noise: Noise | None = StereoNoise(),  # noqa: B008  frozen
    table: Table | None = None,
    seed: int = 0,
    layout: str = "bop",
    renderer: str = "raycast",
    progress: Callable[[int, bool], None] | None = None,
) -> None:
    """Write scenes that are not there yet.

    Args:
        scenes: for each, object -> pose (world frame); they should be at rest.
        objects: object -> mesh of everything in any scene.
        folder: the data set; made where absent.
        views: pictures of a scene.
        intrinsics: of every picture.
        noise: of the depth; None is none.
        table: the table top.
        seed: decides views and noise of each scene by itself, so that a data set may be extended.
        layout: a name of `tamp.perception.dataset.layouts`.
        renderer: "raycast" or "software".
        progress: told each scene's number when it is there, and whether it was already.
    """
    how = layout_of(layout)
    how.write_models(objects, folder)
    top = Table() if table is None else table
    for number, poses in enumerate(scenes):
        there = how.scene_folder(folder, number).is_dir()
        if not there:
            rng = np.random.default_rng([seed, number])
            cameras = list(around(top, views, rng))
            frames = labelled(objects, poses, cameras, intrinsics, noise, top, rng, renderer, how.depth_step)
            how.write_scene(list(frames), folder, number)
        if progress is not None:
            progress(number, there)


def write_random_scene(
    task_files: Sequence[str], folder: str, number: int, *, views: int, count: int, seed: int, layout: str
) -> dict[str, int]:
    """Make a scene of a number from the objects of some tasks and write it: the work of one worker.

    Args:
        task_files: tasks whose objects may be in the scene.
        folder: the data set, which has its models already.
        number: the scene's, which with the seed decides everything about it.
        views: pictures.
        count: objects that are dropped.
        seed: of the data set.
        layout: a name of `tamp.perception.dataset.layouts`.

    Returns:
        {"objects": how many are in it}.
    """
    from tamp.task.files.load import load_task

    objects, looks = pool([load_task(path, allow_outside=True) for path in task_files])
    rng = np.random.default_rng([seed, number])
    poses = random_scene(objects, count, Table(), rng)
    how = layout_of(layout)
    cameras = list(around(Table(), views, rng))
    frames = labelled(looks, poses, cameras, SENSOR, StereoNoise(), Table(), rng, depth_step=how.depth_step)
    how.write_scene(list(frames), Path(folder), number)
    return {"objects": len(poses)}


def pool(tasks: Sequence[Task]) -> tuple[tuple[Object, ...], dict[str, Surface]]:
    """The objects of all tasks, one of each shape under its model's name, and what they look like."""
    found: dict[str, Object] = {}
    for obj in (obj for task in tasks for obj in task.objects):
        found.setdefault(model_name(obj), replace(obj, name=model_name(obj), goal=None))
    objects = tuple(found[name] for name in sorted(found))
    return objects, {obj.name: surface_of(obj) for obj in objects}


def labelled(
    objects: Mapping[str, Surface],
    poses: Mapping[str, Pose],
    cameras: Sequence[Array],
    intrinsics: Intrinsics,
    noise: Noise | None,
    table: Table,
    rng: np.random.Generator,
    renderer: str = "raycast",
    depth_step: int = 1,
) -> Iterator[LabelledFrame]:
    """Pictures of a scene from camera poses (4, 4), each with the poses and masks of all objects.

    Depths are whole multiples of `depth_step` steps of 0.1 mm.
    """
    make = open_renderer(renderer)
    bodies = objects_at(objects, poses)
    with make([*bodies, table_body(table)]) as scene:
        for T in cameras:
            picture = scene.picture(intrinsics, T)
            depth = measured(picture.depth, picture.slant, intrinsics, noise, rng)
            labels = tuple(
                Label(
                    body.name,
                    np.linalg.inv(T) @ body.T_world_body,
                    _alone(body, intrinsics, T, renderer),
                    picture.bodies == place,
                )
                for place, body in enumerate(bodies)
            )
            yield LabelledFrame(intrinsics, T, picture.color, steps(depth, depth_step), labels)


def _alone(body: Body, k: Intrinsics, T: Array, renderer: str) -> NDArray[np.bool_]:
    """Pixels that a body covers if nothing else is there; only the part of the picture around it is drawn."""
    mask = np.zeros((k.height, k.width), dtype=bool)
    to_camera = np.linalg.inv(T) @ body.T_world_body
    points = body.surface.vertices @ to_camera[:3, :3].T + to_camera[:3, 3]
    if points[:, 2].max() < 0.02:
        return mask
    left, top, right, bottom = 0, 0, k.width, k.height
    if points[:, 2].min() > 0.02:
        pixels, _ = k.project(points)
        left, top = (int(max(0, v)) for v in np.floor(pixels.min(axis=0)))
        right, bottom = (int(min(e, v)) for e, v in zip((k.width, k.height), np.ceil(pixels.max(axis=0)), strict=True))
    if right <= left or bottom <= top:
        return mask
    window = Intrinsics(right - left, bottom - top, k.fx, k.fy, k.cx - left, k.cy - top)
    with open_renderer(renderer)([body]) as alone:
        mask[top:bottom, left:right] = alone.picture(window, T).bodies == 0
    return mask
