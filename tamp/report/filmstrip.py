"""An execution as a moving picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tamp.execution.record import Frame
from tamp.report.camera import Camera
from tamp.report.images import save_animation
from tamp.report.render import Stage
from tamp.task import Task

SMALL = Camera(width=640, height=360)


def render_execution(task: Task, frames: Sequence[Frame], path: Path, *, camera: Camera = SMALL) -> None:
    """Write recorded frames as a GIF that plays four times as fast as the robot moved.

    Args:
        task: objects, regions, table and robot.
        frames: at least two, at equal times apart; see `frame_s` of `open_execution`.
        path: the file.
        camera: where it is filmed from.

    Raises:
        ValueError: for fewer than two frames.
    """
    if len(frames) < 2:
        raise ValueError(f"an animation needs at least two frames, not {len(frames)}; execute with frame_s=0.2, say")
    with Stage(task) as stage:
        images = [
            stage.picture(frame.poses, configuration=frame.configuration, opening=frame.opening, camera=camera)
            for frame in frames
        ]
    save_animation(images, path, frame_s=max(0.02, (frames[1].time - frames[0].time) / 4))
