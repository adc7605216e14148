"""Start, goal and end of runs as pictures inside a page."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

from tamp.execution.simulators import NO_PICTURES, can_draw
from tamp.report.rendering.camera import Camera
from tamp.report.rendering.images import data_uri, read_image
from tamp.report.rendering.scene import Stage, goal_poses, marks
from tamp.report.runs import Recorded
from tamp.task import Pose

CAMERA = Camera(width=480, height=300, distance=1.7)


log = logging.getLogger("tamp")


class Gallery:
    """Takes pictures of some runs.

    Args:
        most: of how many runs.
        runs: all that there are; those that are not solved get pictures first.
    """

    def __init__(self, most: int, runs: Sequence[Recorded]) -> None:
        if most and runs and not can_draw():
            log.warning("the report has none: %s", NO_PICTURES)
            most = 0
        ordered = sorted(range(len(runs)), key=lambda i: (runs[i].result.solved, i))
        self._chosen = {id(runs[i]) for i in ordered[:most]}

    def of(self, run: Recorded) -> dict[str, str]:
        """Caption -> data URI: start, goals with marks on regions, end, what was seen; none for a run left out."""
        task = run.task if id(run) in self._chosen else None
        if task is None:
            return {}
        start: Mapping[str, Pose] = run.plans[0].start if run.plans else {o.name: o.pose for o in task.objects}
        goals = goal_poses(task)
        gone = {*goals, *marks(task)}
        still = {name: pose for name, pose in start.items() if name not in gone}
        with Stage(task) as stage:
            shots = {
                "start": stage.picture(start, camera=CAMERA),
                "goal": stage.picture({**still, **goals}, marked=True, camera=CAMERA),
            }
            if run.final_poses:
                shots["end"] = stage.picture(run.final_poses, camera=CAMERA)
        seen = {
            f"look {sight.number}, {path.stem.split('-', 2)[2]}": read_image(path)
            for sight in run.sights
            for path in sight.pictures
        }
        return {caption: data_uri(image) for caption, image in {**shots, **seen}.items()}
