"""Pictures by a software rasterizer: no display, no graphics card, no further library."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.execution.renderer import Lens, TexturedMesh
from tamp.execution.simulators import make_rasterizer
from tamp.perception.cameras.camera import Intrinsics
from tamp.perception.rendering.renderer import AMBIENT, FAR, LIGHT, NEAR, Picture
from tamp.perception.rendering.scene import Body
from tamp.perception.rendering.surface import Surface
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class SoftwareRenderer:
    """Bodies as textured meshes; see `Renderer`."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._files = tempfile.TemporaryDirectory(prefix="tamp-")
        folder = Path(self._files.name)
        self._rasterizer = make_rasterizer([_textured(body, folder, number) for number, body in enumerate(bodies)])

    def __enter__(self) -> SoftwareRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self._rasterizer.close()
        self._files.cleanup()

    def picture(self, intrinsics: Intrinsics, T_world_camera: Array) -> Picture:
        """One picture; a triangle's colour is that of its corners' mean."""
        x, y, z = (LIGHT / np.linalg.norm(LIGHT)).tolist()
        size = intrinsics.width, intrinsics.height
        raster = self._rasterizer.picture(
            Lens(*size, _view(T_world_camera), _projection(intrinsics), (x, y, z), AMBIENT)
        )
        seen = raster.meshes >= 0
        depth = np.zeros(seen.shape, dtype=np.float32)
        depth[seen] = FAR * NEAR / (FAR - (FAR - NEAR) * raster.buffer[seen])
        color = np.where(seen[..., None], raster.color, 0).astype(np.uint8)
        return Picture(color, depth, raster.meshes, _slant(intrinsics, depth))


def _textured(body: Body, folder: Path, number: int) -> TexturedMesh:
    path = folder / f"body_{number}.obj"
    _write_textured(body.surface, path, path.with_suffix(".png"))
    return TexturedMesh(path, path.with_suffix(".png"), Pose.from_matrix(body.T_world_body))


def _slant(intrinsics: Intrinsics, depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Cosines between rays and surfaces from the slopes of the depth: the rasterizer does not give normals."""
    points = intrinsics.points(depth)
    across, along = np.gradient(points, axis=1), np.gradient(points, axis=0)
    normals = np.cross(across, along)
    rays = intrinsics.rays()
    length = np.linalg.norm(normals, axis=2) * np.linalg.norm(rays, axis=2)
    cosine = np.abs(np.einsum("ijk,ijk->ij", normals, rays)) / np.maximum(length, 1e-20)
    return np.where(depth > 0, cosine, 0.0).astype(np.float32)


def _view(T_world_camera: Array) -> Array:
    """OpenGL's view matrix: its camera looks along -z with y up."""
    return np.asarray(np.linalg.inv(T_world_camera @ np.diag([1.0, -1.0, -1.0, 1.0])), dtype=np.float64)


def _projection(k: Intrinsics) -> Array:
    """OpenGL's projection matrix of a pinhole camera.

    The rasterizer takes a pixel's colour and depth at its corner; shifted by half a pixel, it takes them at the centre.
    """
    P = np.zeros((4, 4))
    cx, cy = k.cx - 0.5, k.cy + 0.5
    P[0, 0], P[1, 1] = 2 * k.fx / k.width, 2 * k.fy / k.height
    P[0, 2], P[1, 2] = 1 - 2 * cx / k.width, 2 * cy / k.height - 1
    P[2, 2], P[2, 3] = -(FAR + NEAR) / (FAR - NEAR), -2 * FAR * NEAR / (FAR - NEAR)
    P[3, 2] = -1.0
    return P


def _write_textured(surface: Surface, path: Path, texture: Path) -> None:
    """An OBJ whose triangles each take the colour of one texel block of a texture.

    The rasterizer leaves out what is seen from behind, and scanned meshes have triangles that are inside out: each is
    there both ways round.
    """
    from PIL import Image

    side = int(np.ceil(np.sqrt(len(surface.faces))))
    means = surface.colors[surface.faces].mean(axis=1)
    texels = np.zeros((side * side, 3), dtype=np.uint8)
    texels[: len(means)] = np.rint(means)
    block = 2  # texels a triangle: the middle of a block is far from its neighbours'
    image = texels.reshape(side, side, 3).repeat(block, axis=0).repeat(block, axis=1)
    Image.fromarray(image).save(texture)
    places = np.arange(len(surface.faces))
    u, v = (places % side + 0.5) / side, 1 - (places // side + 0.5) / side
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in surface.vertices.tolist()]
    lines += [f"vt {a!r} {b!r}" for a, b in zip(u.tolist(), v.tolist(), strict=True)]
    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-20)[:, None]
    lines += [f"vn {x!r} {y!r} {z!r}" for x, y, z in normals.tolist()]
    lines += [f"vn {-x!r} {-y!r} {-z!r}" for x, y, z in normals.tolist()]
    for number, triangle in enumerate((surface.faces + 1).tolist(), start=1):
        for normal, corners in ((number, triangle), (number + len(normals), triangle[::-1])):
            lines.append("f " + " ".join(f"{corner}/{number}/{normal}" for corner in corners))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
