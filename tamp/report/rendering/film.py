"""A run as a moving picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tamp.execution.log import Frame
from tamp.report.rendering.camera import Camera
from tamp.report.rendering.images import save_animation
from tamp.report.rendering.scene import Stage
from tamp.task import Task

SMALL = Camera(width=640, height=360)
SPEED = 4.0
"""So many times faster than the robot moved."""


def render_execution(task: Task, frames: Sequence[Frame], path: Path, *, camera: Camera = SMALL) -> None:
    """Write recorded frames as a GIF or MP4 that plays four times as fast as the robot moved.

    Args:
        task: objects, regions, table and robot.
        frames: at least two, at equal times apart; see `frame_s` of `open_execution`.
        path: the file; its ending says the format.
        camera: where it is filmed from.

    Raises:
        ValueError: for fewer than two frames.
        TampError: for an MP4 without the extra that writes it.
    """
    with Stage(task) as stage:
        film(stage, frames, path, camera=camera)


def film(stage: Stage, frames: Sequence[Frame], path: Path, *, camera: Camera = SMALL) -> None:
    """The same on a stage that stands already."""
    if len(frames) < 2:
        raise ValueError(f"an animation needs at least two frames, not {len(frames)}; execute with frame_s=0.2, say")
    images = [
        stage.picture(frame.poses, configuration=frame.configuration, opening=frame.opening, camera=camera)
        for frame in frames
    ]
    save_animation(images, path, frame_s=max(0.02, (frames[1].time - frames[0].time) / SPEED))
