"""Many views of many scenes, rendered with a sensor's noise and labelled; resumable."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Intrinsics, Noise, StereoNoise, looking_at
from tamp.perception.cameras.noise import measured
from tamp.perception.dataset.bop import Label, LabelledFrame, scene_folder, steps, write_models, write_scene
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.scene import Body, objects_at, table_body
from tamp.perception.rendering.surface import Surface
from tamp.task.model import Table
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
        renderer: "raycast" or "software".
        progress: told each scene's number when it is there, and whether it was already.
    """
    write_models(objects, folder)
    top = Table() if table is None else table
    for number, poses in enumerate(scenes):
        there = scene_folder(folder, number).is_dir()
        if not there:
            rng = np.random.default_rng([seed, number])
            cameras = list(around(top, views, rng))
            write_scene(list(labelled(objects, poses, cameras, intrinsics, noise, top, rng, renderer)), folder, number)
        if progress is not None:
            progress(number, there)


def labelled(
    objects: Mapping[str, Surface],
    poses: Mapping[str, Pose],
    cameras: Sequence[Array],
    intrinsics: Intrinsics,
    noise: Noise | None,
    table: Table,
    rng: np.random.Generator,
    renderer: str = "raycast",
) -> Iterator[LabelledFrame]:
    """Pictures of a scene from camera poses (4, 4), each with the poses and masks of all objects."""
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
            yield LabelledFrame(intrinsics, T, picture.color, steps(depth), labels)


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
