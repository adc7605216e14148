"""Which turn depth pictures show, and of what: each is rendered and held against them (analysis by synthesis).

A scanned plate or bowl differs from its own turns by some tenths of a millimetre, which is less than cameras and their
calibration err. But they err alike whichever turn it is. So what is wrong with a view as a whole is fitted to each
turn's residuals and taken out: a small motion, an offset, and what matching windows, which take their nearer side, make
of slopes. What is left differs from turn to turn, over thousands of pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Intrinsics
from tamp.perception.estimation.fusion import LevelFrame, smallest
from tamp.perception.rendering.raycast import RayCaster
from tamp.perception.rendering.scene import Body
from tamp.perception.rendering.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FIRST, CLOSELY = 4, 2
"""Every so many pixels all turns are held against, and the finalists."""

FINALISTS = 6
"""Turns that are looked at closely."""

NEAR = 0.008
"""A pixel is the object's where its depth is this near to that of any turn [m]."""

EDGE, ASIDE = 0.020, 2
"""Pixels with one so much nearer or farther [m] within so many are on an edge, where sensors invent surfaces."""

FEWEST = 100
"""A view of fewer pixels tells nothing."""

CAP = 4.5
"""What a pixel costs at most: three standard deviations."""

LEAST = 1e-4
"""No sensor is more precise than this [m]."""

CLEARLY = 60.0
"""Pictures overrule what fits points better where they are likelier by so much, in the likelihood's logarithm.

Errors of neighbours go together, about twenty pixels of those that are looked at closely: less than three such patches
tell nothing."""

FITS = 4
"""Times that a view's errors are fitted anew, without the pixels that they do not explain."""


@dataclass(frozen=True, eq=False)
class _Window:
    """The part of a frame that shows an object, every so many pixels.

    Attributes:
        intrinsics: of those pixels.
        T_world_camera: shape (4, 4).
        depth: as measured, shape (height, width); 0 is nothing [m].
        step: their distance in the frame [pixels].
    """

    intrinsics: Intrinsics
    T_world_camera: Array
    depth: Array
    step: int

    @staticmethod
    def on(points: Array, seen: LevelFrame, step: int) -> _Window | None:
        """What a frame shows around points (n, 3); None where they are not all before the camera, or beside it."""
        k, T = seen.frame.intrinsics, seen.T_world_camera
        local = (points - T[:3, 3]) @ T[:3, :3]
        if (local[:, 2] <= 0).any():
            return None
        pixels, _ = k.project(local)
        margin = ASIDE * step
        low = np.maximum(np.floor(pixels.min(axis=0)).astype(int) - margin, 0)
        high = np.minimum(np.ceil(pixels.max(axis=0)).astype(int) + margin, (k.width, k.height))
        if (high - low <= 2 * margin).any():
            return None
        rows, columns = (slice(low[axis], high[axis], step) for axis in (1, 0))
        depth = np.where(seen.frame.robot, np.float32(0), seen.frame.depth)[rows, columns].astype(np.float64)
        # The centre of a pixel that is kept stays the centre of a pixel.
        middle = (np.array((k.cx, k.cy)) - low - 0.5) / step + 0.5
        height, width = depth.shape
        return _Window(Intrinsics(width, height, k.fx / step, k.fy / step, *middle.tolist()), T, depth, step)

    def costs(self, rivals: Sequence[tuple[RayCaster, Array]]) -> Array | None:
        """Negative logarithm of how likely the pixels are, but for a constant and a scale, at each pose of each rival.

        Rivals are an object alone, in its own frame, with poses (n, 4, 4): it is the camera that moves from pose to
        pose. All are judged by the same pixels. None: too few pixels.
        """
        pictures = [
            alone.picture(self.intrinsics, camera).depth.astype(np.float64)
            for alone, poses in rivals
            for camera in np.linalg.inv(poses) @ self.T_world_camera
        ]
        clear = np.all([self._clear(z) for z in pictures], axis=0)
        judged = (self.depth > 0) & clear & np.any([np.abs(self.depth - z) < NEAR for z in pictures], axis=0)
        if judged.sum() < FEWEST:
            return None
        left = [self._unexplained(z, judged) for z in pictures]
        scale = max(LEAST, min(map(_deviation, left)))
        return np.array([np.minimum((gap / scale) ** 2 / 2, CAP).sum() for gap in left])

    def _clear(self, z: Array) -> NDArray[np.bool_]:
        """Pixels of a rendered depth that are not on an edge; where nothing is, all is one."""
        depth = z.astype(np.float32)
        nearest, farthest = smallest(depth, ASIDE), -smallest(-depth, ASIDE)
        return np.asarray((nearest > 0) & (farthest - nearest < EDGE))

    def _unexplained(self, z: Array, judged: NDArray[np.bool_]) -> Array:
        """Distances of measured pixels from a rendered surface, less what fits the view's own errors, (m,) [m]."""
        rays = self.intrinsics.rays().astype(np.float64)
        surface = rays * z[..., None]
        along, down = (np.asarray(np.gradient(surface, axis=axis))[judged] for axis in (1, 0))
        facing = np.cross(along, down)
        facing /= np.linalg.norm(facing, axis=1)[:, None]
        points, slant = surface[judged], np.einsum("ij,ij->i", facing, rays[judged])
        gap = (self.depth - z)[judged] * slant
        slopes = [np.abs(np.asarray(np.gradient(z, axis=axis))[judged]) / self.step for axis in (1, 0)]
        errors = np.column_stack(
            [np.cross(points - points.mean(axis=0), facing), facing, slant, *(slope * slant for slope in slopes)]
        )
        return _less_fitted(gap, errors)


@dataclass(frozen=True)
class Shown:
    """What frames say of one of several objects that may be in a place.

    Attributes:
        pose: the number of the pose at which they show it best.
        cost: negative logarithm of how likely they are then, but for what is the same for all that were compared.
    """

    pose: int
    cost: float


def turn_shown(frames: Sequence[LevelFrame], surface: Surface, poses: Array) -> int | None:
    """The number of the pose that frames show.

    Args:
        frames: pictures of a scene that stood still.
        surface: the object's mesh.
        poses: what is to be told apart, T_world_object, shape (n, 4, 4); they differ by a turn of a nearly symmetrical
            shape, and by millimetres.

    Returns:
        None where no frame shows enough of what all of them have in common.
    """
    shown = all_shown(frames, [(surface, poses)])
    return None if shown is None else shown[0].pose


def all_shown(frames: Sequence[LevelFrame], rivals: Sequence[tuple[Surface, Array]]) -> list[Shown] | None:
    """How well frames show each of several objects, at the best of its poses.

    Args:
        frames: pictures of a scene that stood still.
        rivals: meshes, each with poses in one place, T_world_object, shape (n, 4, 4).

    Returns:
        None where no frame shows enough of what all poses have in common.
    """
    firsts, costs = [np.arange(len(poses)) for _, poses in rivals], _costs(frames, rivals, FIRST)
    if costs is not None:  # what is small shows enough only when it is looked at closely
        firsts = [np.argsort(cost, kind="stable")[:FINALISTS] for cost in costs]
    finalists = [(surface, poses[first]) for (surface, poses), first in zip(rivals, firsts, strict=True)]
    closely = _costs(frames, finalists, CLOSELY)
    if closely is not None:
        return [Shown(int(first[c.argmin()]), float(c.min())) for first, c in zip(firsts, closely, strict=True)]
    return None if costs is None else [Shown(int(cost.argmin()), float(cost.min())) for cost in costs]


def _costs(frames: Sequence[LevelFrame], rivals: Sequence[tuple[Surface, Array]], step: int) -> list[Array] | None:
    """Those of all frames that show enough, added up: for each rival those of its poses."""
    surface, poses = rivals[0]
    placed = surface.vertices[np.unique(surface.faces)] @ poses[0, :3, :3].T + poses[0, :3, 3]
    windows = [window for frame in frames if (window := _Window.on(placed, frame, step)) is not None]
    with ExitStack() as opened:
        alone = [opened.enter_context(RayCaster([Body("", surface, np.eye(4))])) for surface, _ in rivals]
        given = [(caster, poses) for caster, (_, poses) in zip(alone, rivals, strict=True)]
        costs = [cost for window in windows if (cost := window.costs(given)) is not None]
    counts = [len(poses) for _, poses in rivals]
    return np.split(np.sum(costs, axis=0), np.cumsum(counts)[:-1]) if costs else None


def _less_fitted(values: Array, columns: Array) -> Array:
    """Values (m,) less their robust regression on columns (m, k): least squares, reweighted by Tukey's function."""
    weights = np.ones(len(values))
    rest = values
    for _ in range(FITS):
        weighed = columns * weights[:, None]
        A = weighed.T @ columns
        ridge = 1e-9 * np.trace(A) * np.eye(len(A))
        rest = values - columns @ np.linalg.solve(A + ridge, weighed.T @ values)
        weights = np.maximum(0.0, 1 - (rest / (4 * max(LEAST, _deviation(rest)))) ** 2) ** 2
    return rest


def _deviation(values: Array) -> float:
    """Standard deviation of normally distributed values, by their median: few that are far off do not count."""
    return 1.4826 * float(np.median(np.abs(values)))
