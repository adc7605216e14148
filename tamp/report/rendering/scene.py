"""Pictures of a task's scene: objects, regions, table, robot, and goals as ghosts."""

from __future__ import annotations

import colorsys
import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.renderer import Color, Item
from tamp.execution.simulators import make_renderer
from tamp.report.rendering.camera import FRONT, Camera
from tamp.report.rendering.images import save_image
from tamp.task import At, Box, On, Pose, Table, Task, task_robot

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Image = NDArray[np.uint8]

TABLE_COLOR: Color = (0.80, 0.74, 0.66, 1.0)
REGION_COLOR: Color = (0.72, 0.80, 0.86, 1.0)
GOAL_COLOR: Color = (0.45, 0.66, 0.50, 1.0)
"""Of a region that something shall stand on."""

MARK = 0.045
"""Side of the mark that an object's goal leaves on a region, in the object's colour [m]."""

GHOST = 0.4
"""Opacity of a goal that is drawn into a scene."""

AWAY = Pose((0.0, 0.0, -50.0))
"""Where what is not in the picture waits."""


def palette(count: int) -> tuple[Color, ...]:
    """`count` opaque colours that are easy to tell apart: hues by the golden ratio, brightness alternating."""
    golden = 0.618033988749895
    tones = ((0.70, 0.92), (0.85, 0.68), (0.45, 0.95))
    return tuple((*colorsys.hsv_to_rgb((0.02 + i * golden) % 1.0, *tones[i % len(tones)]), 1.0) for i in range(count))


class Stage:
    """A scene to take pictures of; a context manager. Objects keep their colours between pictures.

    Args:
        task: objects, regions, table and robot.
        robot: whether the robot is in the picture.

    Raises:
        TaskError: where an object's mesh cannot be used.
        RobotError: where the robot's URDF cannot be used.
    """

    def __init__(self, task: Task, *, robot: bool = True) -> None:
        flat = _flat_things(task, task.table)
        # Each object twice, each in its own colour, all out of sight: as it stands, and as its goal.
        colors = palette(len(task.objects))
        actors = [Item(thing.shape, color, AWAY) for thing, color in zip(task.objects, colors, strict=True)]
        self._marked = marks(task)
        tiles = [
            Item(Box((MARK, MARK, 0.002)), color, AWAY)
            for thing, color in zip(task.objects, colors, strict=True)
            if thing.name in self._marked
        ]
        self._spec = task_robot(task)
        self._renderer = make_renderer((*flat, *actors, *actors, *tiles), self._spec if robot else None)
        names = [thing.name for thing in task.objects]
        self._bodies = dict(zip(names, itertools.count(len(flat))))
        self._ghosts = dict(zip(names, itertools.count(len(flat) + len(names))))
        marked = [name for name in names if name in self._marked]
        self._tiles = dict(zip(marked, itertools.count(len(flat) + 2 * len(names))))

    def __enter__(self) -> Stage:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the scene; every later call fails."""
        self._renderer.close()

    def picture(
        self,
        poses: Mapping[str, Pose],
        *,
        configuration: Sequence[float] | None = None,
        opening: float | None = None,
        marked: bool = False,
        camera: Camera = FRONT,
    ) -> Image:
        """The scene as the camera sees it, shape (height, width, 3), red, green, blue in 0..255.

        Args:
            poses: object -> pose (world frame); an object absent here is left out of the picture.
            configuration: the arm's joint positions [rad]; home where it is None.
            opening: distance between the finger pads [m]; open where it is None.
            marked: whether each object that shall stand anywhere on a region is marked there by its colour.
            camera: where the picture is taken from.
        """
        self._place(self._bodies, poses)
        self._place(self._tiles, self._marked if marked else {})
        self._place(self._ghosts, {})
        self._renderer.set_robot(
            self._spec.home if configuration is None else configuration,
            self._spec.gripper.stroke if opening is None else opening,
        )
        return self._renderer.picture(camera.view)

    def picture_with_goals(
        self,
        poses: Mapping[str, Pose],
        goals: Mapping[str, Pose],
        *,
        camera: Camera = FRONT,
    ) -> Image:
        """The scene with the goals drawn into it as ghosts and marks: two pictures laid over each other."""
        scene = self.picture(poses, marked=True, camera=camera).astype(np.float64)
        self._place(self._ghosts, goals)
        meant = self._renderer.picture(camera.view).astype(np.float64)
        return np.asarray(np.rint((1 - GHOST) * scene + GHOST * meant), dtype=np.uint8)

    def _place(self, items: Mapping[str, int], poses: Mapping[str, Pose]) -> None:
        for name, item in items.items():
            self._renderer.place(item, poses.get(name, AWAY))


def _flat_things(task: Task, table: Table) -> list[Item]:
    """Table and regions as boxes. A region is a sheet on the table."""
    x, y = table.center
    top = Item(Box((*table.size, table.thickness)), TABLE_COLOR, Pose((x, y, -table.thickness / 2)))
    wanted = {thing.goal.target for thing in task.objects if isinstance(thing.goal, On)}
    sheets = [
        Item(
            Box((*region.size, 0.001)),
            GOAL_COLOR if region.name in wanted else REGION_COLOR,
            Pose((*region.center, 0.0)),
        )
        for region in task.regions
    ]
    return [top, *sheets]


def render_task(
    task: Task,
    poses: Mapping[str, Pose],
    path: Path,
    *,
    configuration: Sequence[float] | None = None,
    goals: bool = False,
    camera: Camera = FRONT,
) -> None:
    """Write one picture of a task's scene.

    Args:
        task: objects, regions, table and robot.
        poses: object -> pose (world frame).
        path: an image file; its ending says the format, such as .png.
        configuration: the arm's joint positions [rad]; home where it is None.
        goals: whether goal poses are drawn as ghosts.
        camera: where the picture is taken from.
    """
    with Stage(task) as stage:
        if goals:
            image = stage.picture_with_goals(poses, goal_poses(task), camera=camera)
        else:
            image = stage.picture(poses, configuration=configuration, camera=camera)
    save_image(image, path)


def marks(task: Task) -> dict[str, Pose]:
    """Object -> where its mark lies on the region that is its goal, in rows; objects with other goals are absent."""
    found = {}
    for region in task.regions:
        names = [item.name for item in task.objects if isinstance(item.goal, On) and item.goal.target == region.name]
        columns = max(1, int(region.size[1] / (1.25 * MARK)))
        for index, name in enumerate(names):
            row, column = divmod(index, columns)
            x = region.center[0] + region.size[0] / 2 - MARK * (0.75 + 1.25 * row)
            y = region.center[1] - region.size[1] / 2 + MARK * (0.75 + 1.25 * column)
            found[name] = Pose((x, y, 0.001))
    return found


def goal_poses(task: Task) -> dict[str, Pose]:
    """Object -> the pose it shall stand at; objects whose goal is no pose are absent."""
    return {item.name: item.goal.pose for item in task.objects if isinstance(item.goal, At)}
