"""Estimates drawn over the picture that they come from: each object's mask, outline, axes and name."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Frame, Intrinsics
from tamp.perception.estimate import Estimate
from tamp.perception.notes import Note, written
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.scene import objects_at
from tamp.perception.rendering.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

TINT = 0.35
"""How much of its own colour covers an object, at full confidence."""

AXIS = 0.05
"""Length of a drawn axis [m]."""

AXES = ((230, 30, 30), (30, 200, 30), (40, 80, 255))


def overlay(
    frame: Frame,
    objects: Mapping[str, Surface],
    estimates: Mapping[str, Estimate],
    *,
    errors: Mapping[str, float] = MappingProxyType({}),
    shrink: int = 1,
    renderer: str = "raycast",
) -> NDArray[np.uint8]:
    """A frame's picture with every estimate drawn into it, shape (height, width, 3).

    An object covers what is behind it; what is uncertain is tinted faintly. Axes are x red, y green, z blue. Beside
    each stands its name and how sure it is; what was not seen at all is named in a corner.

    Args:
        frame: the picture.
        objects: object -> what it looks like.
        estimates: object -> estimate.
        errors: object -> how far its estimate is off [m], where that is known and shall be told.
        shrink: so much narrower and lower the result is.
        renderer: "raycast" or "software".
    """
    k = frame.intrinsics.scaled(1 / shrink)
    image = frame.color[::shrink, ::shrink][: k.height, : k.width].copy()
    poses = {name: e.pose for name, e in estimates.items() if e.pose is not None and name in objects}
    bodies = objects_at(objects, poses)
    with open_renderer(renderer)(bodies) as scene:
        shown = scene.picture(k, frame.T_world_camera).bodies if bodies else np.full(image.shape[:2], -1)
    colors = {body.name: _color(list(objects).index(body.name)) for body in bodies}
    for place, body in enumerate(bodies):
        color, mask = colors[body.name], shown == place
        _blend(image, mask, color, TINT * (0.3 + 0.7 * estimates[body.name].confidence))
        _blend(image, mask & ~_inner(mask), color, 1.0)
    T_camera_world = np.linalg.inv(frame.T_world_camera)
    for body in bodies:
        T = T_camera_world @ body.T_world_body
        for axis, shade in enumerate(AXES):
            line = T[:3, 3] + np.linspace(0, AXIS, 160)[:, None] * T[:3, axis]
            _dots(image, k, line, np.array(shade, dtype=np.float64))
    notes = []
    for body in bodies:
        middle = T_camera_world @ body.T_world_body[:, 3]
        if spot := _spot(middle[:3], k):
            notes.append(Note(_said(body.name, estimates[body.name], errors), spot, colors[body.name]))
    unseen = [name for name in objects if name not in poses]
    return written(image, notes, shown >= 0, "\n".join(("not seen:", *unseen)) if unseen else "")


def save_picture(picture: NDArray[np.uint8], path: Path) -> None:
    """Write a picture (height, width, 3) as PNG; its folder is made where absent."""
    from PIL import Image

    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(picture).save(path)


def _color(number: int) -> Array:
    """A colour for an object by its number, well apart from those of the numbers next to it; 0 to 255."""
    return 255 * np.array(colorsys.hsv_to_rgb((0.13 + 0.618 * number) % 1.0, 1.0, 1.0))


def _said(name: str, estimate: Estimate, errors: Mapping[str, float]) -> str:
    off = f"{100 * errors[name]:.1f} cm off, " if name in errors else ""
    return f"{name}\n{off}{estimate.confidence:.0%} sure"


def _spot(point: Array, k: Intrinsics) -> tuple[float, float] | None:
    """The pixel of a point in the optical frame; None where the picture does not reach it."""
    if point[2] <= 0.02:
        return None
    (u, v) = k.project(point[None])[0][0]
    return (float(u), float(v)) if 0 <= u < k.width and 0 <= v < k.height else None


def _blend(image: NDArray[np.uint8], mask: NDArray[np.bool_], color: Array, opacity: float) -> None:
    image[mask] = np.rint((1 - opacity) * image[mask] + opacity * color).astype(np.uint8)


def _inner(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels of a mask whose four neighbours belong to it."""
    padded = np.pad(mask, 1)
    return padded[2:, 1:-1] & padded[:-2, 1:-1] & padded[1:-1, 2:] & padded[1:-1, :-2] & mask


def _dots(image: NDArray[np.uint8], k: Intrinsics, points: Array, color: Array) -> None:
    """Dots of two by two pixels, in place."""
    ahead = points[points[:, 2] > 0.02]
    if not len(ahead):
        return
    pixels, _ = k.project(ahead)
    u, v = pixels.astype(int).T
    height, width = image.shape[:2]
    inside = (u >= 0) & (u < width - 1) & (v >= 0) & (v < height - 1)
    for du, dv in ((0, 0), (1, 0), (0, 1), (1, 1)):
        image[v[inside] + dv, u[inside] + du] = color.astype(np.uint8)
