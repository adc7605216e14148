"""Pictures of a scene by PyBullet's software renderer: no display, no graphics card."""

from __future__ import annotations

import colorsys
import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.bodies import Body, Color, Material, create_body
from tamp.execution.bullet import pybullet
from tamp.execution.robot_loading import load_robot_body
from tamp.report.camera import FRONT, Camera
from tamp.report.images import save_image
from tamp.task import At, Box, Pose, Table, Task, load_robot

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Image = NDArray[np.uint8]

TABLE_COLOR: Color = (0.80, 0.74, 0.66, 1.0)
REGION_COLOR: Color = (0.72, 0.80, 0.86, 1.0)
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
        self._files = tempfile.TemporaryDirectory(prefix="tamp-")
        self._client: int = pybullet.connect(pybullet.DIRECT)
        try:
            self._build(task, robot)
        except BaseException:
            self.close()
            raise

    def _build(self, task: Task, robot: bool) -> None:
        client, folder = self._client, Path(self._files.name)
        pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
        for size, pose, color in _flat_things(task, task.table):
            create_body(client, folder, Box(size), Material(0.0, 1.0, color), pose)
        self._bodies = self._actors(task)
        self._ghosts = self._actors(task)
        spec = load_robot(task.robot)
        self._robot = load_robot_body(client, folder, spec, spec.home, visible=True) if robot else None

    def _actors(self, task: Task) -> dict[str, Body]:
        """One body for each object, each in its own colour, all out of sight."""
        folder = Path(self._files.name)
        return {
            item.name: create_body(self._client, folder, item.shape, Material(0.0, 1.0, color), AWAY)
            for item, color in zip(task.objects, palette(len(task.objects)), strict=True)
        }

    def __enter__(self) -> Stage:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the scene; every later call fails."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1
            self._files.cleanup()

    def picture(
        self,
        poses: Mapping[str, Pose],
        *,
        configuration: Sequence[float] | None = None,
        opening: float | None = None,
        camera: Camera = FRONT,
    ) -> Image:
        """The scene as the camera sees it, shape (height, width, 3), red, green, blue in 0..255.

        Args:
            poses: object -> pose (world frame); an object absent here is left out of the picture.
            configuration: the arm's joint positions [rad]; home where it is None.
            opening: distance between the finger pads [m]; open where it is None.
            camera: where the picture is taken from.
        """
        self._place(self._bodies, poses)
        self._place(self._ghosts, {})
        if self._robot is not None:
            spec = self._robot.spec
            self._robot.set_state(
                spec.home if configuration is None else configuration,
                spec.gripper.stroke if opening is None else opening,
            )
        return _photograph(self._client, camera)

    def picture_with_goals(
        self,
        poses: Mapping[str, Pose],
        goals: Mapping[str, Pose],
        *,
        camera: Camera = FRONT,
    ) -> Image:
        """The scene with the goals drawn into it as ghosts: two pictures laid over each other."""
        scene = self.picture(poses, camera=camera).astype(np.float64)
        self._place(self._ghosts, goals)
        meant = _photograph(self._client, camera).astype(np.float64)
        return np.asarray(np.rint((1 - GHOST) * scene + GHOST * meant), dtype=np.uint8)

    def _place(self, actors: Mapping[str, Body], poses: Mapping[str, Pose]) -> None:
        for name, body in actors.items():
            body.place(self._client, poses.get(name, AWAY))


def _flat_things(task: Task, table: Table) -> list[tuple[tuple[float, float, float], Pose, Color]]:
    """Table and regions as boxes: size, pose, colour. A region is a sheet on the table."""
    x, y = table.center
    things = [((*table.size, table.thickness), Pose((x, y, -table.thickness / 2)), TABLE_COLOR)]
    sheets = [((*region.size, 0.001), Pose((*region.center, 0.0)), REGION_COLOR) for region in task.regions]
    return things + sheets


def _photograph(client: int, camera: Camera) -> Image:
    view = pybullet.computeViewMatrix(camera.eye, camera.target, (0.0, 0.0, 1.0), physicsClientId=client)
    projection = pybullet.computeProjectionMatrixFOV(
        math.degrees(camera.field_of_view), camera.width / camera.height, 0.05, 6.0, physicsClientId=client
    )
    pixels = pybullet.getCameraImage(
        camera.width,
        camera.height,
        viewMatrix=view,
        projectionMatrix=projection,
        lightDirection=(0.6, 0.5, 1.6),
        lightDistance=3.0,
        shadow=1,
        lightAmbientCoeff=0.62,
        lightDiffuseCoeff=0.42,
        lightSpecularCoeff=0.05,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
        physicsClientId=client,
    )[2]
    return np.array(pixels, dtype=np.uint8).reshape(camera.height, camera.width, 4)[:, :, :3].copy()


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


def goal_poses(task: Task) -> dict[str, Pose]:
    """Object -> the pose it shall stand at; objects whose goal is no pose are absent."""
    return {item.name: item.goal.pose for item in task.objects if isinstance(item.goal, At)}
