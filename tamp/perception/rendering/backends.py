"""Renderers by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tamp.errors import TampError
from tamp.perception.rendering.renderer import Renderer
from tamp.perception.rendering.scene import Body


def open_renderer(name: str) -> Callable[[Sequence[Body]], Renderer]:
    """The renderer of a name, "raycast" or "software", to be called with the bodies.

    Raises:
        TampError: where the name is unknown, or its extra is not installed.
    """
    if name == "raycast":
        from tamp.perception.rendering.raycast import RayCaster

        return RayCaster
    if name == "software":
        from tamp.perception.rendering.software import SoftwareRenderer

        return SoftwareRenderer
    raise TampError(f"unknown renderer {name!r}; valid are raycast, software")
