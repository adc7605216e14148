"""Where a picture is taken from."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tamp.execution.renderer import View


@dataclass(frozen=True)
class Camera:
    """A camera that looks at a point, z up.

    Attributes:
        target: what it looks at (world frame) [m].
        distance: [m].
        azimuth: direction from the target to the camera, from x towards y [rad].
        elevation: over the horizontal [rad].
        width, height: of the picture [pixels].
        field_of_view: vertical [rad].
    """

    target: tuple[float, float, float] = (-0.14, 0.0, 0.15)
    distance: float = 2.1
    azimuth: float = math.radians(32)
    elevation: float = math.radians(36)
    width: int = 1280
    height: int = 720
    field_of_view: float = math.radians(38)

    @property
    def eye(self) -> tuple[float, float, float]:
        """Where it stands (world frame) [m]."""
        x, y, z = self.target
        flat = self.distance * math.cos(self.elevation)
        return (
            x + flat * math.cos(self.azimuth),
            y + flat * math.sin(self.azimuth),
            z + self.distance * math.sin(self.elevation),
        )

    @property
    def view(self) -> View:
        """The same as the renderer takes it."""
        return View(self.eye, self.target, self.field_of_view, self.width, self.height)


FRONT = Camera()
"""From the front right, table and robot in full."""
