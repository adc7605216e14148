"""Pictures of a task's scenes as one camera of a set-up takes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.errors import TampError
from tamp.perception.cameras.capture import shoot, views
from tamp.perception.cameras.setup import OCRTOC_2021, load_setup
from tamp.perception.rendering.scene import surfaces
from tamp.task import Pose, Task, task_robot

if TYPE_CHECKING:
    from numpy.typing import NDArray

DEPTH_STEP = 1e-4
"""What a step of a written depth is [m]."""


def photographs(
    task: Task, scenes: Mapping[str, Mapping[str, Pose]], camera: str, setup: Path | None = None, seed: int = 0
) -> Iterator[tuple[str, NDArray[np.uint8], NDArray[np.uint16]]]:
    """Yield name, colour (height, width, 3), and depth (height, width) in steps of 0.1 mm with the sensor's noise.

    Args:
        task: objects, table and robot.
        scenes: name -> object -> pose (world frame); an object absent there is not in it.
        camera: a name of the set-up.
        setup: the set-up's file; None is OCRTOC's of 2021.
        seed: of the noise.

    Raises:
        TampError: where there is no such camera, or the extra `perception` is not installed.
    """
    robot = task_robot(task)
    found = {c.name: c for c in load_setup(setup or OCRTOC_2021, robot)}
    if camera not in found:
        raise TampError(f"{setup or OCRTOC_2021}: there is no camera {camera!r}; valid are {', '.join(found)}")
    looks = surfaces(task)
    shots = views([found[camera]], robot)
    for name, poses in scenes.items():
        for number, shot in enumerate(shoot(looks, poses, shots, robot, table=task.table, seed=seed)):
            place = f"-{number}" if len(shots) > 1 else ""
            depth = np.clip(np.rint(shot.frame.depth / DEPTH_STEP), 0, 2**16 - 1).astype(np.uint16)
            yield f"{camera}{place}-{name}", shot.frame.color, depth
