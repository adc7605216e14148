"""What a renderer is: something that is given bodies once and takes pictures of them from anywhere."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Protocol

import numpy as np

from tamp.perception.cameras.camera import Intrinsics

if TYPE_CHECKING:
    from numpy.typing import NDArray

NEAR, FAR = 0.02, 6.0
"""Nothing nearer or farther than this is drawn [m]."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture without noise.

    Attributes:
        color: shape (height, width, 3), uint8; black where nothing is.
        depth: along the optical axis, shape (height, width), float32 [m]; 0 where nothing is.
        bodies: index of the body that each pixel shows, -1 for none; int16 (height, width).
        slant: cosine between each pixel's ray and its surface's normal, float32 (height, width).
    """

    color: NDArray[np.uint8]
    depth: NDArray[np.float32]
    bodies: NDArray[np.int16]
    slant: NDArray[np.float32]


class Renderer(Protocol):
    """Bodies to be looked at; a context manager, as it may hold what must be freed."""

    def picture(self, intrinsics: Intrinsics, T_world_camera: NDArray[np.float64]) -> Picture:
        """The bodies as a pinhole camera at a pose (4, 4) of its optical frame sees them."""

    def __enter__(self) -> Renderer: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


LIGHT = np.array([0.35, 0.25, 0.9])
"""Direction to a distant lamp, world frame; both renderers shade by it."""

AMBIENT = 0.55
"""Share of the light that comes from everywhere."""
