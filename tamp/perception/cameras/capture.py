"""Taking a set-up's pictures of a scene: rendered, then spoilt as the sensors would."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Camera, Frame
from tamp.perception.cameras.noise import measured, miscalibrated
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.robot import camera_pose
from tamp.perception.rendering.scene import Body, objects_at, robot_body, table_body
from tamp.perception.rendering.surface import Surface
from tamp.task.model import Table
from tamp.task.pose import Pose
from tamp.task.robot import RobotSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROBOT_MARGIN = 4
"""Pixels around the robot's picture that count as robot: encoders and calibration err."""


@dataclass(frozen=True)
class View:
    """A camera, and the robot while it takes a picture.

    Attributes:
        camera: the camera.
        q: the arm's configuration [rad].
        opening: distance between the finger pads [m]; None is wide open.
    """

    camera: Camera
    q: tuple[float, ...]
    opening: float | None = None


def views(cameras: Sequence[Camera], robot: RobotSpec) -> tuple[View, ...]:
    """Every picture that a set-up takes; a camera in the world sees the arm at home."""
    return tuple(View(camera, tuple(q)) for camera in cameras for q in camera.viewpoints or (robot.home,))


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame and the truth behind it.

    Attributes:
        frame: what a perceiver is given.
        T_world_camera: where the camera truly was, shape (4, 4).
        depth: true depth, shape (height, width) [m].
        visible: index into the names of objects of what each pixel shows, -1 for anything else.
    """

    frame: Frame
    T_world_camera: NDArray[np.float64]
    depth: NDArray[np.float32]
    visible: NDArray[np.int16]


def shoot(
    looks: Mapping[str, Surface],
    poses: Mapping[str, Pose],
    shots: Sequence[View],
    robot: RobotSpec,
    *,
    table: Table | None = None,
    seed: int = 0,
    first: int = 0,
    masks: bool = False,
    renderer: str = "raycast",
) -> Iterator[Shot]:
    """Take pictures one after the other.

    Args:
        looks: object -> what it looks like; their order numbers the masks.
        poses: object -> where it is (world frame); an object absent here is not there.
        shots: what is to be taken.
        robot: the robot in the pictures.
        table: the table in the pictures.
        seed: decides every error of sensors and calibration, for each view by itself.
        first: the number of the first view, which decides its errors too.
        masks: whether the frames tell which object each pixel shows.
        renderer: "raycast" or "software".

    Raises:
        TampError: where the renderer is unknown or not installed.
        RobotError: where a camera is mounted on a link that the robot does not have.
    """
    make = open_renderer(renderer)
    names = list(looks)
    still = [table_body(Table() if table is None else table), *objects_at(looks, poses)]
    number = {body.name: names.index(body.name) for body in still[1:]}
    for index, view in enumerate(shots, start=first):
        bodies: list[Body] = [*still, robot_body(robot, view.q, view.opening)]
        T = camera_pose(view.camera, robot, view.q)
        with make(bodies) as scene:
            picture = scene.picture(view.camera.intrinsics, T)
        lookup = np.array([number.get(body.name, -1) for body in bodies] + [-1], dtype=np.int16)
        visible = lookup[picture.bodies]
        rng = np.random.default_rng([seed, index, _number(view.camera.name)])
        frame = Frame(
            view.camera.name,
            view.camera.intrinsics,
            _believed(view.camera, T, seed, rng),
            picture.color,
            measured(picture.depth, picture.slant, view.camera.intrinsics, view.camera.noise, rng),
            _grown(picture.bodies == len(bodies) - 1, ROBOT_MARGIN),
            visible if masks else None,
        )
        yield Shot(frame, T, picture.depth, visible)


def calibrated_pose(camera: Camera, T_world_camera: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
    """A camera's pose (4, 4) with the error of its mount, which is the same in all views of a scene."""
    mount = np.random.default_rng([seed, _number(camera.name)])
    return miscalibrated(T_world_camera, camera.calibration, mount, view=False)


def _believed(camera: Camera, T: NDArray[np.float64], seed: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Where calibration has the camera in one view, which has an error of its own."""
    return miscalibrated(calibrated_pose(camera, T, seed), camera.calibration, rng, view=True)


def _number(name: str) -> int:
    """The same number for a name in every process."""
    return zlib.crc32(name.encode())


def _grown(mask: NDArray[np.bool_], margin: int) -> NDArray[np.bool_]:
    from scipy import ndimage

    return np.asarray(ndimage.maximum_filter(mask, size=2 * margin + 1))
