"""Some of a set-up's cameras and of their viewpoints: what is asked of perception is harder with fewer."""

from __future__ import annotations

import sys
from collections.abc import Collection, Sequence
from dataclasses import replace

from tamp.perception.cameras.camera import Camera


def some_cameras(cameras: Sequence[Camera], names: Collection[str] = (), viewpoints: int = 0) -> tuple[Camera, ...]:
    """Cameras of these names, the moving ones with their first viewpoints alone.

    Args:
        cameras: of a set-up.
        names: of those that look; none is all.
        viewpoints: how many of each; 0 is all.
    """
    known = [camera.name for camera in cameras]
    if unknown := sorted(set(names) - set(known)):
        sys.exit(f"no camera is called {unknown[0]!r}; there are: {', '.join(known)}")
    if viewpoints < 0:
        sys.exit(f"--viewpoints {viewpoints}: 0 for all, or how many of the first")
    return tuple(
        replace(camera, viewpoints=camera.viewpoints[: viewpoints or None])
        for camera in cameras
        if not names or camera.name in names
    )
