"""Pictures by casting one ray a pixel (Embree, through the package embreex)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.errors import TampError
from tamp.perception.cameras.camera import Intrinsics
from tamp.perception.rendering.renderer import AMBIENT, FAR, LIGHT, NEAR, Picture
from tamp.perception.rendering.scene import Body
from tamp.perception.rendering.surface import Surface
from tamp.versions import how_to_install

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]


def _scene(bodies: Sequence[Body]) -> Any:
    """Embree's scene of some bodies, numbered in their order."""
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ModuleNotFoundError:
        raise TampError(f"ray casting needs an extra: {how_to_install('perception')}") from None
    scene = EmbreeScene(robust=True)
    for body in bodies:
        R, t = body.T_world_body[:3, :3], body.T_world_body[:3, 3]
        vertices = np.ascontiguousarray(body.surface.vertices @ R.T + t, dtype=np.float32)
        TriangleMesh(scene, vertices, np.ascontiguousarray(body.surface.faces, dtype=np.int32))
    return scene


def escapes(surface: Surface, origins: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rays, origins and directions of shape (n, 3) in the surface's frame, meet nothing of the surface.

    Raises:
        TampError: where the extra `perception` is not installed.
    """
    scene = _scene([Body("", surface, np.eye(4))])
    rays = [np.ascontiguousarray(values, dtype=np.float32) for values in (origins, directions)]
    return np.asarray(scene.run(*rays) < 0)


class RayCaster:
    """Casts rays at bodies; see `Renderer`.

    Raises:
        TampError: where the extra `perception` is not installed.
    """

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._scene = _scene(bodies)
        self._faces = [body.surface.faces for body in bodies]
        self._colors = [body.surface.colors.astype(np.float32) for body in bodies]

    def __enter__(self) -> RayCaster:
        return self

    def __exit__(self, *_: object) -> None:
        del self._scene

    def picture(self, intrinsics: Intrinsics, T_world_camera: NDArray[np.float64]) -> Picture:
        """One ray through each pixel's centre."""
        shape = (intrinsics.height, intrinsics.width)
        R = T_world_camera[:3, :3].astype(np.float32)
        # Rays have depth 1 at length 1, so that Embree's distance is the depth.
        directions = np.ascontiguousarray(intrinsics.rays().reshape(-1, 3) @ R.T)
        origins = np.tile(T_world_camera[:3, 3].astype(np.float32), (len(directions), 1))
        found = self._scene.run(origins, directions, output=1)
        depth, bodies = found["tfar"], found["geomID"].astype(np.int16)
        seen = (bodies >= 0) & (depth > NEAR) & (depth < FAR)
        bodies = np.where(seen, bodies, np.int16(-1))
        normals, cosine = _toward(found["Ng"], directions)
        color = self._shaded(bodies, found["primID"], found["u"], found["v"], normals)
        return Picture(
            color.reshape(*shape, 3),
            np.where(seen, depth, np.float32(0)).reshape(shape),
            bodies.reshape(shape),
            np.where(seen, cosine, np.float32(0)).reshape(shape),
        )

    def _shaded(
        self, bodies: NDArray[np.int16], triangle: NDArray[np.int32], u: Floats, v: Floats, normals: Floats
    ) -> NDArray[np.uint8]:
        """Colours between the corners', by Lambert's law."""
        color = np.zeros((len(bodies), 3), dtype=np.float32)
        for index, (faces, colors) in enumerate(zip(self._faces, self._colors, strict=True)):
            at = np.flatnonzero(bodies == index)
            corners = colors[faces[triangle[at]]]
            weights = np.stack([1 - u[at] - v[at], u[at], v[at]], axis=1)
            color[at] = np.einsum("nij,ni->nj", corners, weights)
        lamp = (LIGHT / np.linalg.norm(LIGHT)).astype(np.float32)
        light = AMBIENT + (1 - AMBIENT) * np.maximum(normals @ lamp, 0.0)
        return np.asarray(np.clip(np.rint(color * light[:, None]), 0, 255), dtype=np.uint8)


def _toward(normals: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Unit normals turned to the camera, and the cosines between them and the rays back to it."""
    length = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    unit = normals / np.maximum(length, 1e-20)[:, None]
    along = np.einsum("ij,ij->i", unit, directions)
    unit *= np.where(along > 0, np.float32(-1), np.float32(1))[:, None]
    return unit, np.abs(along) / np.sqrt(np.einsum("ij,ij->i", directions, directions))
