"""Colour, depth and bodies by PyBullet's software renderer, from textured meshes and OpenGL's two matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.pybullet.client import pybullet
from tamp.execution.renderer import Lens, Raster, TexturedMesh

if TYPE_CHECKING:
    from numpy.typing import NDArray


class PyBulletRasterizer:
    """The rasterizer's protocol in PyBullet; see tamp.execution.renderer."""

    def __init__(self, meshes: Sequence[TexturedMesh]) -> None:
        self._client: int = pybullet.connect(pybullet.DIRECT)
        pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=self._client)
        self._index = {self._add(mesh): number for number, mesh in enumerate(meshes)}

    def _add(self, mesh: TexturedMesh) -> int:
        visual = pybullet.createVisualShape(
            pybullet.GEOM_MESH, fileName=str(mesh.path), rgbaColor=(1, 1, 1, 1), physicsClientId=self._client
        )
        made: int = pybullet.createMultiBody(
            baseVisualShapeIndex=visual,
            basePosition=mesh.pose.xyz,
            baseOrientation=mesh.pose.quat,
            physicsClientId=self._client,
        )
        image = pybullet.loadTexture(str(mesh.texture), physicsClientId=self._client)
        pybullet.changeVisualShape(made, -1, textureUniqueId=image, physicsClientId=self._client)
        return made

    def picture(self, lens: Lens) -> Raster:
        """One picture of all meshes."""
        width, height = lens.width, lens.height
        _, _, color, buffer, mask = pybullet.getCameraImage(
            width,
            height,
            viewMatrix=_by_columns(lens.view),
            projectionMatrix=_by_columns(lens.projection),
            lightDirection=lens.light,
            lightDistance=10.0,
            shadow=0,
            lightAmbientCoeff=lens.ambient,
            lightDiffuseCoeff=1 - lens.ambient,
            lightSpecularCoeff=0.0,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        ids = np.asarray(mask).reshape(height, width)
        meshes = np.full((height, width), -1, dtype=np.int16)
        for body, number in self._index.items():
            meshes[ids == body] = number
        rgb = np.asarray(color, dtype=np.uint8).reshape(height, width, 4)[:, :, :3]
        return Raster(rgb, np.asarray(buffer, dtype=np.float64).reshape(height, width), meshes)

    def close(self) -> None:
        """Free the meshes; every later call fails."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1


def _by_columns(matrix: NDArray[np.float64]) -> list[float]:
    return [float(value) for value in matrix.T.reshape(-1)]
