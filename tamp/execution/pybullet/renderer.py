"""Pictures by PyBullet's software renderer: no display, no graphics card."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.pybullet.bodies import Body, Material, create_body
from tamp.execution.pybullet.client import pybullet
from tamp.execution.pybullet.robot import RobotBody, load_robot_body
from tamp.execution.renderer import Item, View
from tamp.task import Pose, RobotSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Image = NDArray[np.uint8]

NEAR, FAR = 0.05, 6.0
"""What is nearer to the camera or farther away is not drawn [m]."""


class PyBulletRenderer:
    """The renderer's protocol in PyBullet; see tamp.execution.renderer."""

    def __init__(self, items: Sequence[Item], robot: RobotSpec | None) -> None:
        self._files = tempfile.TemporaryDirectory(prefix="tamp-")
        self._client: int = pybullet.connect(pybullet.DIRECT)
        self._bodies: tuple[Body, ...] = ()
        self._robot: RobotBody | None = None
        try:
            self._build(items, robot)
        except BaseException:
            self.close()
            raise

    def _build(self, items: Sequence[Item], robot: RobotSpec | None) -> None:
        client, folder = self._client, Path(self._files.name)
        pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
        self._bodies = tuple(
            create_body(client, folder, item.shape, Material(0.0, 1.0, item.color), item.pose) for item in items
        )
        if robot is not None:
            self._robot = load_robot_body(client, folder, robot, robot.home, visible=True)

    def close(self) -> None:
        """Free the scene; every later call fails."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1
            self._files.cleanup()

    def place(self, item: int, pose: Pose) -> None:
        """Put an item at a pose."""
        self._bodies[item].place(self._client, pose)

    def set_robot(self, q: Sequence[float], opening: float) -> None:
        """Put the arm at `q` [rad] and the fingers `opening` [m] apart."""
        if self._robot is not None:
            self._robot.set_state(q, opening)

    def picture(self, view: View) -> Image:
        """The scene, shape (height, width, 3), red, green, blue in 0..255."""
        looking = pybullet.computeViewMatrix(view.eye, view.target, (0.0, 0.0, 1.0), physicsClientId=self._client)
        projection = pybullet.computeProjectionMatrixFOV(
            math.degrees(view.field_of_view), view.width / view.height, NEAR, FAR, physicsClientId=self._client
        )
        pixels = pybullet.getCameraImage(
            view.width,
            view.height,
            viewMatrix=looking,
            projectionMatrix=projection,
            lightDirection=(0.6, 0.5, 1.6),
            lightDistance=3.0,
            shadow=1,
            lightAmbientCoeff=0.62,
            lightDiffuseCoeff=0.42,
            lightSpecularCoeff=0.05,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )[2]
        return np.array(pixels, dtype=np.uint8).reshape(view.height, view.width, 4)[:, :, :3].copy()
