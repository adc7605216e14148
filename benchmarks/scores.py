"""OCRTOC's public tasks by every metric: doing nothing, the bound, and what a perfect robot would score by letting go.

The floor is the error of the goal scenes after they have settled in our physics, against the goals as given. Tasks of
2020 also settle their start scenes and are drawn: `seen_px` counts the picture's pixels that show objects.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.ocrtoc import DATA
from benchmarks.parts.harness import Row, main
from tamp.execution.settling.settle import settle
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.report.rendering.camera import FRONT
from tamp.report.rendering.scene import Stage, goal_poses
from tamp.scoring import METRICS, Evaluation, Metric, evaluate
from tamp.scoring.metrics import EDE
from tamp.task import Mesh, Pose, Task
from tamp.task.files.load import load_task

EXCHANGED = replace(EDE, name="ede, exchanged", interchange=True)
"""The paper's metric if objects that are alike might take each other's goals, which it does not let them."""

CAMERA = replace(FRONT, width=640, height=360)
Floors = Mapping[str, Mapping[str, Pose | None]]


def rows(quick: bool) -> Iterator[Row]:
    """The means of each year by each metric, then one row for each world of 2020."""
    if not DATA.is_dir():
        sys.exit(f"the tasks are not there: {DATA}")
    with tempfile.TemporaryDirectory() as folder:
        for year in ("2021", "2020"):
            paths = import_ocrtoc(DATA / year, Path(folder) / year).paths
            tasks = [load_task(path) for path in paths[:: 10 if quick else 1]]
            floors = {task.name: _settled_goals(task) for task in tasks}
            yield from (_means(year, tasks, floors, m) for m in (EDE, EXCHANGED, *METRICS[1:]))
            if year == "2020":
                yield from (_world(task, floors) for task in tasks)


def _settled_goals(task: Task) -> dict[str, Pose | None]:
    """Where everything ends when all is let go at its goal; objects without one are out of the scene."""
    return {**dict.fromkeys(o.name for o in task.objects), **settle(task, goal_poses(task)).poses}


def _means(year: str, tasks: Sequence[Task], floors: Floors, metric: Metric) -> Row:
    idle = [evaluate(task, {o.name: o.pose for o in task.objects}, metric) for task in tasks]
    floor = [evaluate(task, floors[task.name], metric) for task in tasks]
    return {"set": year, "metric": metric.name, "tasks": len(tasks), **_errors(metric.unit, idle, floor)}


def _errors(unit: str, idle: Sequence[Evaluation], floor: Sequence[Evaluation]) -> Row:
    """Means over tasks: centimetres, or percent where the metric is a share."""
    key = "cm" if unit == "m" else "%"
    return {
        f"do_nothing_{key}": 100 * float(np.mean([e.error for e in idle])),
        f"bound_{key}": 100 * float(np.mean([e.bound for e in idle])),
        f"floor_{key}": 100 * float(np.mean([e.error for e in floor])),
    }


def _world(task: Task, floors: Floors) -> Row:
    """One world: that it settles and can be drawn, and its errors by the paper's metric."""
    start = settle(task)
    idle, floor = (evaluate(task, poses, EDE) for poses in (start.poses, floors[task.name]))
    given = evaluate(task, {o.name: o.pose for o in task.objects}, EDE)
    with Stage(task, robot=False) as stage:
        empty, scene = stage.picture({}, camera=CAMERA), stage.picture(start.poses, camera=CAMERA)
    return {
        "set": task.name,
        "metric": EDE.name,
        "tasks": 1,
        **_errors(EDE.unit, [given], [floor]),
        "objects": len(task.objects),
        "with_goal": len(given.objects),
        "stand_ins": sum(isinstance(o.shape, Mesh) and o.shape.path.stem == "stand_in" for o in task.objects),
        "at_rest": start.resting,
        "moved_max_cm": 100 * max(start.moved.values()),
        "lost": len(idle.lost),
        "seen_px": int((empty != scene).any(axis=2).sum()),
    }


if __name__ == "__main__":
    main("scores", lambda quick: list(rows(quick)))
