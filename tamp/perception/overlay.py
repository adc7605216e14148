"""Estimates drawn over the picture that they come from: each object's points and axes, faint where it is uncertain."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.model import object_model
from tamp.perception.rendering.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

POINTS = 1200
AXIS = 0.05
"""Length of a drawn axis [m]."""

AXES = ((230, 30, 30), (30, 200, 30), (40, 80, 255))


def overlay(frame: Frame, objects: Mapping[str, Surface], estimates: Mapping[str, Estimate]) -> NDArray[np.uint8]:
    """A frame's picture with every estimate drawn into it, shape (height, width, 3).

    Points are drawn whether or not something stands before them; x is red, y green, z blue.
    """
    image = frame.color.copy()
    T_camera_world = np.linalg.inv(frame.T_world_camera)
    for number, (name, surface) in enumerate(objects.items()):
        estimate = estimates.get(name)
        if estimate is None or estimate.pose is None:
            continue
        T = T_camera_world @ estimate.pose.matrix
        model = object_model(surface)
        local = model.points[:POINTS] @ T[:3, :3].T + T[:3, 3]
        facing = np.einsum("ij,ij->i", model.normals[:POINTS] @ T[:3, :3].T, local) < 0
        color = np.array(colorsys.hsv_to_rgb((0.13 + 0.618 * number) % 1.0, 1.0, 1.0)) * 255
        _dots(image, frame, local[facing], color, 0.35 + 0.6 * estimate.confidence)
        for axis, shade in enumerate(AXES):
            line = T[:3, 3] + np.linspace(0, AXIS, 160)[:, None] * T[:3, axis]
            _dots(image, frame, line, np.array(shade, dtype=np.float64), 1.0)
    return image


def save_picture(picture: NDArray[np.uint8], path: Path) -> None:
    """Write a picture (height, width, 3) as PNG; its folder is made where absent."""
    from PIL import Image

    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(picture).save(path)


def _dots(image: NDArray[np.uint8], frame: Frame, points: Array, color: Array, opacity: float) -> None:
    """Dots of two by two pixels, in place."""
    ahead = points[points[:, 2] > 0.02]
    if not len(ahead):
        return
    pixels, _ = frame.intrinsics.project(ahead)
    u, v = pixels.astype(int).T
    height, width = image.shape[:2]
    inside = (u >= 0) & (u < width - 1) & (v >= 0) & (v < height - 1)
    for du, dv in ((0, 0), (1, 0), (0, 1), (1, 1)):
        at = v[inside] + dv, u[inside] + du
        image[at] = np.rint((1 - opacity) * image[at] + opacity * color).astype(np.uint8)
